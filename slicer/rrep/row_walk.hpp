#pragma once
/// Rows and columns of pixels that ascend, as those of a layer's crossings do, without a division for each.

#include <cstdint>

namespace plumbline::inline slicer {

class RowWalk {
 public:
  /// @param row  to begin at
  explicit RowWalk(std::uint32_t columns, std::uint32_t row = 0)
      : columns_(columns), row_(row), begin_(row * columns) {}

  /// @param pixel  row * columns + column, in the row of the last one or further down
  void go_to(std::uint32_t pixel) {
    while (pixel - begin_ >= columns_) {
      begin_ += columns_;
      ++row_;
    }
    column_ = pixel - begin_;
  }
  std::uint32_t row() const { return row_; }
  std::uint32_t column() const { return column_; }

 private:
  std::uint32_t columns_, row_, begin_;
  std::uint32_t column_ = 0;
};

}  // namespace plumbline::inline slicer
