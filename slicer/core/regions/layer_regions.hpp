#pragma once
/// The connected regions of one mask, white and black.

#include <algorithm>
#include <cstdint>
#include <span>

#include "slicer/core/arena.hpp"
#include "slicer/core/bit_image.hpp"
#include "slicer/core/error.hpp"

namespace plumbline::inline slicer {

/// Regions of one layer, as runs of pixels. Black pixels are joined at sides, white ones at sides and, unless the settings
/// say otherwise, at corners. Black pixels at the border belong to one region, the outside. The index of its first run names
/// a region.
class LayerRegions {
 public:
  struct Settings {
    std::uint32_t runs_per_row = 64;       ///< room for runs: of a row on average
    bool join_white_corners = true;        ///< white pixels that touch at a corner only belong together
    const char* stage = "layer features";  ///< named in errors
  };
  struct Run {
    std::uint16_t first, last;  ///< columns, `last` included
  };
  static constexpr std::uint32_t kNone = ~std::uint32_t{0};
  static constexpr std::uint32_t kOutside = 0;  ///< the outside region; run 0 is not a run of the image

  /// Number of runs that there is room for; a layer has at most as many regions.
  static std::size_t most_runs(std::uint32_t rows, const Settings& settings) {
    return std::size_t{rows} * settings.runs_per_row + 1;
  }
  static std::size_t bytes_needed(std::uint32_t rows, const Settings& settings = kDefaults);
  /// @retval ErrorCode::kOutOfMemory
  [[nodiscard]] static Expected<LayerRegions> create(std::uint32_t columns, std::uint32_t rows, Arena& arena,
                                                     const Settings& settings = kDefaults);

  /// Finds the regions of `mask`.
  /// @returns false if it has more than Settings::runs_per_row runs a row on average; then there are no regions
  bool label(ConstBitImage mask);

  std::uint32_t rows() const { return static_cast<std::uint32_t>(row_first_.size() - 1); }
  /// The runs of row r are [row_begin(r), row_begin(r + 1)), from left to right, alternately black and white, black first. An
  /// empty black run has first > last.
  std::uint32_t row_begin(std::uint32_t row) const { return row_first_[row]; }
  const Run& run(std::uint32_t i) const { return runs_[i]; }
  bool white(std::uint32_t row, std::uint32_t i) const { return ((i - row_first_[row]) & 1U) != 0; }
  std::uint32_t region(std::uint32_t i) const { return region_[i]; }
  /// Pixels; of the outside: the largest value.
  std::uint32_t area(std::uint32_t region) const { return area_[region]; }
  std::uint32_t run_count() const { return row_first_.back(); }  ///< run 0 included
  /// The first row with a black pixel that is not outside; rows() if there is none.
  std::uint32_t first_enclosed_row() const { return first_enclosed_row_; }
  /// The row that holds run i.
  std::uint32_t row_of(std::uint32_t i) const {
    const auto next = std::upper_bound(row_first_.begin(), row_first_.end(), i);
    return static_cast<std::uint32_t>(next - row_first_.begin()) - 1;
  }
  /// The run that holds a pixel.
  std::uint32_t run_at(std::uint32_t column, std::uint32_t row) const {
    std::uint32_t i = row_begin(row);
    while (i + 1 < row_begin(row + 1) && (runs_[i].first > runs_[i].last || runs_[i].last < column)) ++i;
    return i;
  }
  /// Calls visit(row, i) for each white run.
  template <class Visit>
  void for_each_white_run(Visit visit) const {
    for (std::uint32_t r = 0; r < rows(); ++r) {
      for (std::uint32_t i = row_begin(r) + 1; i < row_begin(r + 1); i += 2) visit(r, i);
    }
  }
  /// Calls visit(row, i) for the runs of a region but the outside, until it returns true.
  /// @returns whether it did
  template <class Visit>
  bool any_run_of(std::uint32_t region, Visit visit) const {
    std::uint32_t left = area(region);
    for (std::uint32_t r = row_of(region); r < rows() && left > 0; ++r) {
      for (std::uint32_t i = row_begin(r); i < row_begin(r + 1); ++i) {
        if (region_[i] != region) continue;
        left -= runs_[i].last + 1U - runs_[i].first;
        if (visit(r, i)) return true;
      }
    }
    return false;
  }

 private:
  static const Settings kDefaults;

  void join_rows(std::uint32_t row);

  std::uint32_t columns_ = 0;
  std::uint32_t white_reach_ = 1;  ///< columns to the side at which white runs of neighbouring rows touch
  std::span<Run> runs_;
  std::span<std::uint32_t> region_;  ///< of a run; while label() runs, the parent in disjoint sets of runs
  std::span<std::uint32_t> area_;
  std::span<std::uint32_t> row_first_;  ///< rows + 1
  std::uint32_t first_enclosed_row_ = 0;
};

/// Two runs of one colour that share columns in the same row of both layers.
struct RegionContact {
  std::uint32_t below, above;  ///< regions
  std::uint32_t pixels;        ///< that both runs have
  bool white;
};

/// Calls use(contact) for every such pair of white or of black runs in a row, from left to right.
template <class Use>
void for_each_contact_in_row(const LayerRegions& below, const LayerRegions& above, std::uint32_t row, bool white,
                             Use use) {
  // Colours alternate, black first. An empty black run overlaps none.
  std::uint32_t a = below.row_begin(row) + (white ? 1 : 0);
  std::uint32_t b = above.row_begin(row) + (white ? 1 : 0);
  const std::uint32_t a_end = below.row_begin(row + 1);
  const std::uint32_t b_end = above.row_begin(row + 1);
  while (a < a_end && b < b_end) {
    const LayerRegions::Run ra = below.run(a);
    const LayerRegions::Run rb = above.run(b);
    const std::uint32_t first = std::max(ra.first, rb.first);
    const std::uint32_t last = std::min(ra.last, rb.last);
    if (first <= last) use(RegionContact{below.region(a), above.region(b), 1U + last - first, white});
    rb.last <= ra.last ? b += 2 : a += 2;
  }
}

/// Calls use(contact) for every such pair, by rows.
template <class Use>
void for_each_contact(const LayerRegions& below, const LayerRegions& above, Use use) {
  for (std::uint32_t r = 0; r < below.rows(); ++r) {
    for (const bool white : {false, true}) for_each_contact_in_row(below, above, r, white, use);
  }
}

}  // namespace plumbline::inline slicer
