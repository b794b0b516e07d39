#pragma once
/// Images with one byte a pixel, to compare with the images of 64 pixels a word.

#include <cstdint>
#include <ostream>
#include <vector>

#include "slicer/core/bit_image.hpp"

namespace plumbline::testing {

/// A black BitImage that owns its memory.
class OwnedImage {
 public:
  OwnedImage(std::uint32_t columns, std::uint32_t rows)
      : words_(BitImage::words_needed(columns, rows), 0), columns_(columns), rows_(rows) {}
  BitImage view() { return {words_, columns_, rows_}; }
  ConstBitImage view() const { return {words_, columns_, rows_}; }

  bool clear_past_the_last_column() const {
    for (std::uint32_t r = 0; r < rows_; ++r) {
      if ((view().row(r).back() & ~view().last_word_mask()) != 0) return false;
    }
    return true;
  }

 private:
  std::vector<std::uint64_t> words_;
  std::uint32_t columns_;
  std::uint32_t rows_;
};

/// One byte a pixel; pixels outside are black.
class Pixels {
 public:
  Pixels(std::uint32_t columns, std::uint32_t rows)
      : columns_(columns), rows_(rows), pixels_(std::size_t{columns} * rows, 0) {}
  explicit Pixels(ConstBitImage image) : Pixels(image.columns(), image.rows()) {
    for (std::uint32_t r = 0; r < rows_; ++r) {
      for (std::uint32_t c = 0; c < columns_; ++c) set(c, r, image.at(c, r));
    }
  }
  std::uint32_t columns() const { return columns_; }
  std::uint32_t rows() const { return rows_; }
  bool at(std::int64_t column, std::int64_t row) const {
    if (column < 0 || row < 0 || column >= columns_ || row >= rows_) return false;
    return pixels_[static_cast<std::size_t>(row) * columns_ + static_cast<std::size_t>(column)] != 0;
  }
  void set(std::uint32_t column, std::uint32_t row, bool white) {
    pixels_[std::size_t{row} * columns_ + column] = white ? 1 : 0;
  }
  void toggle(std::uint32_t index) { pixels_[index] ^= 1; }
  std::uint64_t count() const {
    std::uint64_t sum = 0;
    for (const auto pixel : pixels_) sum += pixel;
    return sum;
  }
  OwnedImage image() const {
    OwnedImage image(columns_, rows_);
    for (std::uint32_t r = 0; r < rows_; ++r) {
      for (std::uint32_t c = 0; c < columns_; ++c) {
        if (at(c, r)) image.view().set(c, r);
      }
    }
    return image;
  }
  bool operator==(const Pixels&) const = default;
  friend std::ostream& operator<<(std::ostream& out, const Pixels& pixels) {
    for (std::uint32_t r = 0; r < pixels.rows_; ++r) {
      out << '\n';
      for (std::uint32_t c = 0; c < pixels.columns_; ++c) out << (pixels.at(c, r) ? '#' : '.');
    }
    return out;
  }

 private:
  std::uint32_t columns_;
  std::uint32_t rows_;
  std::vector<std::uint8_t> pixels_;
};

/// Whether (column, row) is in a square of 2 x 2 pixels of one colour.
inline bool in_a_square(const Pixels& pixels, std::int64_t column, std::int64_t row, bool white) {
  for (const std::int64_t c : {column - 1, column}) {
    for (const std::int64_t r : {row - 1, row}) {
      if (pixels.at(c, r) == white && pixels.at(c + 1, r) == white && pixels.at(c, r + 1) == white &&
          pixels.at(c + 1, r + 1) == white) {
        return true;
      }
    }
  }
  return false;
}

/// The closing of the opening with a square of 2 x 2: white stays where it fills a square, then black likewise.
inline Pixels opened_and_closed_by_definition(const Pixels& in) {
  Pixels opened(in.columns(), in.rows());
  Pixels closed(in.columns(), in.rows());
  for (std::uint32_t r = 0; r < in.rows(); ++r) {
    for (std::uint32_t c = 0; c < in.columns(); ++c) opened.set(c, r, in_a_square(in, c, r, true));
  }
  for (std::uint32_t r = 0; r < in.rows(); ++r) {
    for (std::uint32_t c = 0; c < in.columns(); ++c) closed.set(c, r, !in_a_square(opened, c, r, false));
  }
  return closed;
}

}  // namespace plumbline::testing
