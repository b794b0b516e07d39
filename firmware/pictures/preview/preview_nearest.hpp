#pragma once
/// The solid that is nearest to somebody beside the print.

#include <algorithm>
#include <cstdint>
#include <span>

#include "firmware/pictures/preview/preview_layout.hpp"
#include "slicer/core/bit_image.hpp"

namespace plumbline::firmware::inline pictures::preview {

enum class Beside : std::uint8_t { kFront, kBack, kLeft };

/// How far the nearest solid is, layer after layer: by column for somebody in front or behind, by row for somebody on the left. It takes
/// time for what changes from one layer to the next, not for all that is solid.
class NearestSolid {
 public:
  /// @param distances  the caller's memory: as many as the grid has columns, or rows
  NearestSolid(std::span<std::uint32_t> distances, const Extent& extent, Beside from)
      : distances_(distances), extent_(extent), from_(from) {
    std::fill(distances_.begin(), distances_.end(), none());
  }

  /// Distance of what there is not: that of the far side.
  std::uint32_t none() const {
    return from_ == Beside::kLeft ? extent_.column_end - extent_.column : extent_.row_end - extent_.row;
  }
  bool by_row() const { return from_ == Beside::kLeft; }
  /// Columns or rows that may have solid.
  std::uint32_t first() const { return from_ == Beside::kLeft ? extent_.row : extent_.column; }
  std::uint32_t end() const { return from_ == Beside::kLeft ? extent_.row_end : extent_.column_end; }

  /// Pixels from the near side of the extent.
  std::uint32_t distance(std::uint32_t column, std::uint32_t row) const {
    switch (from_) {
      case Beside::kFront: return row - extent_.row;
      case Beside::kBack: return extent_.row_end - 1 - row;
      case Beside::kLeft: return column - extent_.column;
    }
    return none();
  }
  /// A pixel has become solid.
  void add(std::uint32_t column, std::uint32_t row) {
    std::uint32_t& nearest = distances_[from_ == Beside::kLeft ? row : column];
    nearest = std::min(nearest, distance(column, row));
  }
  /// Passes by the pixels that are no longer solid. Only then distances() are those of `section`.
  void settle(const BitImage& section) {
    for (std::uint32_t place = first(); place < end(); ++place) {
      std::uint32_t& nearest = distances_[place];
      while (nearest < none() && !is_solid(section, place, nearest)) ++nearest;
    }
  }
  std::span<const std::uint32_t> distances() const { return distances_; }

 private:
  bool is_solid(const BitImage& section, std::uint32_t place, std::uint32_t distance) const {
    switch (from_) {
      case Beside::kFront: return section.at(place, extent_.row + distance);
      case Beside::kBack: return section.at(place, extent_.row_end - 1 - distance);
      case Beside::kLeft: return section.at(extent_.column + distance, place);
    }
    return false;
  }

  std::span<std::uint32_t> distances_;
  const Extent& extent_;
  Beside from_;
};

}  // namespace plumbline::firmware::inline pictures::preview
