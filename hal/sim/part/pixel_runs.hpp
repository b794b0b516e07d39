#pragma once
/// The regions of one layer as runs of pixels.

#include <algorithm>
#include <cstdint>
#include <span>
#include <vector>

#include "slicer/core/bit_image.hpp"

namespace plumbline {

/// Regions of pixels that are joined at their sides, numbered in the order of their first runs: by row, then by column.
///
/// Runs are labelled row by row (Rosenfeld and Pfaltz 1966) with disjoint sets. Time and memory follow the number of runs, not of
/// pixels, beyond one look at each word of the image.
class PixelRuns {
 public:
  static constexpr std::uint32_t kNone = ~std::uint32_t{0};

  struct Run {
    std::uint32_t begin = 0, end = 0;  ///< columns, half open
    std::uint32_t region = 0;
  };
  struct Region {
    std::uint32_t pixels = 0;
    std::uint32_t sides_x = 0;    ///< pixel sides along x on its outline, holes included
    std::uint32_t sides_y = 0;    ///< the same along y
    std::uint32_t row = 0;        ///< of its widest run
    std::uint32_t column = 0;     ///< middle of that run
    std::uint32_t width = 0;      ///< of that run
    std::uint32_t top_row = 0;    ///< its first row
    std::uint32_t top_begin = 0;  ///< and the first column there
  };

  /// The white regions of `image`.
  void find_white(ConstBitImage image);
  /// The black regions between the white runs. Region 0 is the outside: all that reaches the image's border, or rows without white.
  /// @param columns  of the image
  void find_black(const PixelRuns& white, std::uint32_t columns);

  std::uint32_t first_row() const { return first_row_; }
  std::uint32_t end_row() const { return first_row_ + static_cast<std::uint32_t>(row_begin_.size()) - 1; }
  /// @param row  in [first_row(), end_row())
  std::span<const Run> row(std::uint32_t row) const {
    const std::size_t at = row - first_row_;
    return std::span(runs_).subspan(row_begin_[at], row_begin_[at + 1] - row_begin_[at]);
  }
  std::span<const Region> regions() const { return regions_; }
  /// The region of a pixel, or kNone.
  std::uint32_t region_at(std::uint32_t column, std::uint32_t row) const;
  /// Calls use(row, run) for the runs of the regions for which which(region) is true.
  template <class Which, class Use>
  void for_each_run_of(Which which, Use use) const {
    for (std::uint32_t r = first_row(); r < end_row(); ++r) {
      for (const Run& run : row(r)) {
        if (which(run.region)) use(r, run);
      }
    }
  }

 private:
  void clear(std::uint32_t first_row);
  void end_of_row();
  /// Finds which runs touch, in parents_ and shared_.
  void join_rows();
  /// Joins what reaches the border with run 0, which stands for the outside and is in no row.
  void join_outside(std::uint32_t columns);
  void number_regions();

  std::uint32_t first_row_ = 0;
  std::vector<std::uint32_t> row_begin_ = {0};  ///< of the rows from first_row_ on, and the end
  std::vector<Run> runs_;
  std::vector<std::uint32_t> parents_;
  std::vector<std::uint32_t> shared_;  ///< pixels of a run that lie below one of its region
  std::vector<Region> regions_;
};

/// Calls use(a, b, pixels) for each pair of runs of two sets that lie above each other in `pixels` > 0 pixels.
template <class Use>
void for_each_contact(const PixelRuns& a, const PixelRuns& b, Use use) {
  const std::uint32_t end = std::min(a.end_row(), b.end_row());
  for (std::uint32_t r = std::max(a.first_row(), b.first_row()); r < end; ++r) {
    const auto in_a = a.row(r);
    const auto in_b = b.row(r);
    for (std::size_t i = 0, j = 0; i < in_a.size() && j < in_b.size();) {
      const std::uint32_t from = std::max(in_a[i].begin, in_b[j].begin);
      const std::uint32_t to = std::min(in_a[i].end, in_b[j].end);
      if (from < to) use(in_a[i].region, in_b[j].region, to - from);
      in_a[i].end < in_b[j].end ? ++i : ++j;
    }
  }
}

/// Sets or clears the pixels of a run.
inline void fill(BitImage image, std::uint32_t row, const PixelRuns::Run& run, bool white) {
  const auto words = image.row(row);
  for (std::uint32_t w = run.begin / 64; w <= (run.end - 1) / 64; ++w) {
    std::uint64_t bits = ~std::uint64_t{0};
    if (w == run.begin / 64) bits &= ~std::uint64_t{0} << (run.begin % 64);
    if (w == (run.end - 1) / 64) bits &= ~std::uint64_t{0} >> (63 - (run.end - 1) % 64);
    words[w] = white ? words[w] | bits : words[w] & ~bits;
  }
}

}  // namespace plumbline
