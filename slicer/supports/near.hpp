#pragma once
/// Finds pixels that have a white pixel within a distance, 64 at a time.

#include <bit>
#include <cstdint>
#include <span>

#include "slicer/core/arena.hpp"
#include "slicer/core/bit_image.hpp"
#include "slicer/core/error.hpp"
#include "slicer/supports/disc.hpp"

namespace plumbline {

/// A disc as a table of its half width in each row.
class Disc {
 public:
  Disc() = default;
  /// @retval ErrorCode::kOutOfMemory  bytes_needed() from the top of the arena
  [[nodiscard]] static Expected<Disc> create(const PixelPitch& pitch, Nanometres radius, Arena& arena);
  static std::size_t bytes_needed(const PixelPitch& pitch, Nanometres radius);

  /// Of the pixels `wanted` in a word of a row, those that have a white pixel of `image` within the disc's radius.
  std::uint64_t near(ConstBitImage image, std::uint32_t row, std::uint32_t word, std::uint64_t wanted) const;

  std::uint32_t rows() const { return static_cast<std::uint32_t>(reach_.size()) - 1; }  ///< above and below the centre

 private:
  std::span<std::uint32_t> reach_;  ///< columns, by distance of the row from the centre
};

}  // namespace plumbline
