#pragma once
/// Draws supports into masks, layer after layer or in any order.

#include <cstdint>
#include <span>

#include "slicer/core/arena.hpp"
#include "slicer/core/bit_image.hpp"
#include "slicer/core/error.hpp"
#include "slicer/supports/supports.hpp"

namespace plumbline {

/// Knows which supports a layer has. The next layer costs what is in it, another one a look at the whole list.
class SupportPainter {
 public:
  SupportPainter() = default;
  /// Takes the list of those at work from the bottom of the arena.
  /// @param supports  at most 65535; must outlive the painter
  /// @retval ErrorCode::kOutOfMemory
  [[nodiscard]] static Expected<SupportPainter> create(const Supports& supports, Arena& arena);

  static std::size_t bytes_needed(std::size_t supports) { return Arena::rounded(supports * sizeof(std::uint16_t)); }

  /// Makes white what the supports are in `layer`; what is white stays it.
  /// @param touched  one bit a word of `image`: set where a word was looked at, whether it changed or not
  /// @returns pixels that were black
  std::uint64_t draw(std::uint32_t layer, BitImage image, BitImage touched);

 private:
  void go_to(std::uint32_t layer);

  const Supports* supports_ = nullptr;
  std::span<std::uint16_t> active_;  ///< indices of those in layer at_
  std::size_t active_count_ = 0;
  std::size_t next_ = 0;  ///< first of the list that begins above at_
  std::int64_t at_ = -1;
};

}  // namespace plumbline
