#pragma once
/// Draws supports into masks, in any order of layers.

#include <array>
#include <cstdint>
#include <span>

#include "slicer/core/arena.hpp"
#include "slicer/core/bit_image.hpp"
#include "slicer/core/error.hpp"
#include "slicer/supports/drawing/supports.hpp"

namespace plumbline::inline slicer {

/// Tracks which struts are in a layer. Going to the next layer takes time for its struts only, going to any other layer a pass
/// over the whole list.
class SupportPainter {
 public:
  SupportPainter() = default;
  /// Takes the list of struts in a layer from the bottom of the arena.
  /// @param supports  must outlive the painter
  /// @retval ErrorCode::kOutOfMemory
  [[nodiscard]] static Expected<SupportPainter> create(const Supports& supports, Arena& arena);

  static std::size_t bytes_needed(std::size_t struts) { return Arena::rounded(struts * sizeof(std::uint32_t)); }

  /// Draws the struts of `layer` in white.
  /// @param touched  one row a strip (kStripColumns) of `image`, one bit for each of its rows; set where it was drawn on, whether
  ///                 it changed or not
  void draw(std::uint32_t layer, BitImage image, BitImage touched);
  /// As draw(), at twice its cost.
  /// @returns number of pixels that were black before
  std::uint64_t draw_and_count(std::uint32_t layer, BitImage image, BitImage touched);

 private:
  /// Half widths of a disc's rows. Pillars and braces of a print have few radii, so they are found once for many struts and layers.
  struct Rows {
    static constexpr std::uint32_t kMost = 192;

    Nanometres radius = -1;
    std::uint32_t count = 0;  ///< on either side of the middle one, which is the first
    std::array<std::uint16_t, kMost + 1> reach = {};
    std::array<std::uint64_t, kMost + 1> narrow = {};  ///< pixels of the rows that fit into a word
  };

  void go_to(std::uint32_t layer);
  const Rows* rows_of(Nanometres radius);
  // Each calls ink(word, bits) for each word of the image that it draws pixels into.
  template <class Ink>
  void draw_struts(std::uint32_t layer, BitImage image, BitImage touched, Ink ink);
  template <class Ink>
  void draw_disc(const StrutSection& disc, BitImage image, BitImage touched, Ink ink);
  template <class Ink>
  void draw_span(std::uint32_t row, std::uint32_t begin, std::uint32_t end, BitImage image, BitImage touched, Ink ink);

  const Supports* supports_ = nullptr;
  std::span<std::uint32_t> active_;  ///< indices of the struts in layer at_
  std::size_t active_count_ = 0;
  std::size_t next_ = 0;  ///< index of the first strut that begins above at_
  std::int64_t at_ = -1;
  std::array<Rows, 8> rows_;
};

}  // namespace plumbline::inline slicer
