#include "slicer/core/regions/layer_regions.hpp"

#include <algorithm>
#include <bit>

#include "slicer/core/disjoint_sets.hpp"

namespace plumbline::inline slicer {
namespace {

/// Calls visit(end) for each run of a row, from left to right, alternately black and white, black first.
/// @param visit  gets the column behind the run; returns whether to go on
/// @returns whether all calls did
template <class Visit>
bool for_each_run_end(std::span<const std::uint64_t> row, std::uint32_t columns, Visit visit) {
  std::uint64_t before = 0;  // the last pixel of the word before
  std::uint32_t end = 0;
  if (!is_blank(row)) {
    for (std::uint32_t w = 0; w < row.size(); ++w) {
      std::uint64_t changes = row[w] ^ (row[w] << 1 | before);
      before = row[w] >> 63;
      for (; changes != 0; changes &= changes - 1) {
        end = w * 64 + static_cast<std::uint32_t>(std::countr_zero(changes));
        if (!visit(end)) return false;
      }
    }
  }
  return end == columns || visit(columns);
}

}  // namespace

const LayerRegions::Settings LayerRegions::kDefaults;

std::size_t LayerRegions::bytes_needed(std::uint32_t rows, const Settings& settings) {
  const std::size_t runs = most_runs(rows, settings);
  return Arena::rounded(runs * sizeof(Run)) + 2 * Arena::rounded(runs * sizeof(std::uint32_t)) +
         Arena::rounded((std::size_t{rows} + 1) * sizeof(std::uint32_t));
}

Expected<LayerRegions> LayerRegions::create(std::uint32_t columns, std::uint32_t rows, Arena& arena,
                                            const Settings& settings) {
  const std::size_t runs = most_runs(rows, settings);
  LayerRegions regions;
  PLUMBLINE_TRY(arena.take_top(regions.runs_, runs, settings.stage));
  PLUMBLINE_TRY(arena.take_top(regions.region_, runs, settings.stage));
  PLUMBLINE_TRY(arena.take_top(regions.area_, runs, settings.stage));
  PLUMBLINE_TRY(arena.take_top(regions.row_first_, std::size_t{rows} + 1, settings.stage));
  regions.columns_ = columns;
  regions.white_reach_ = settings.join_white_corners ? 1 : 0;
  std::fill(regions.row_first_.begin(), regions.row_first_.end(), 1);
  regions.first_enclosed_row_ = rows;
  return regions;
}

void LayerRegions::join_rows(std::uint32_t row) {
  DisjointSets sets(region_);
  std::uint32_t above = row_first_[row - 1];
  const std::uint32_t above_end = row_first_[row];
  if (above < above_end && runs_[above].first > runs_[above].last) ++above;
  for (std::uint32_t i = row_first_[row]; i < row_first_[row + 1]; ++i) {
    if (runs_[i].first > runs_[i].last) continue;
    const bool is_white = white(row, i);
    const std::uint32_t reach = is_white ? white_reach_ : 0;
    while (above < above_end && runs_[above].last + reach < runs_[i].first) ++above;
    for (std::uint32_t k = above; k < above_end && runs_[k].first <= runs_[i].last + reach; ++k) {
      if (white(row - 1, k) == is_white) sets.unite(i, k);
    }
  }
}

bool LayerRegions::label(ConstBitImage mask) {
  DisjointSets sets(region_);
  sets.start(kOutside);
  std::uint32_t count = 1;
  for (std::uint32_t r = 0; r < mask.rows(); ++r) {
    row_first_[r] = count;
    const bool is_border_row = r == 0 || r + 1 == mask.rows();
    std::uint32_t column = 0;
    const bool room = for_each_run_end(mask.row(r), columns_, [&](std::uint32_t end) {
      if (count == runs_.size()) return false;
      // Columns fit 16 bits. An empty black run is [1, 0].
      runs_[count] =
          end > column ? Run{static_cast<std::uint16_t>(column), static_cast<std::uint16_t>(end - 1)} : Run{1, 0};
      const bool is_white = ((count - row_first_[r]) & 1U) != 0;
      const bool at_border = column == 0 || end == columns_ || is_border_row;
      region_[count] = !is_white && end > column && at_border ? kOutside : count;
      ++count;
      column = end;
      return true;
    });
    if (!room) {
      std::fill(row_first_.begin(), row_first_.end(), 1);
      first_enclosed_row_ = mask.rows();
      return false;
    }
    row_first_[r + 1] = count;
    // Of two black rows, both are outside.
    if (r > 0 && count - row_first_[r - 1] > 2) join_rows(r);
  }
  sets.flatten(count);
  std::fill_n(area_.begin(), count, 0);
  first_enclosed_row_ = mask.rows();
  for (std::uint32_t r = mask.rows(); r-- > 0;) {
    for (std::uint32_t i = row_first_[r]; i < row_first_[r + 1]; ++i) {
      if (region_[i] == kOutside || runs_[i].first > runs_[i].last) continue;
      area_[region_[i]] += 1U + runs_[i].last - runs_[i].first;
      if (!white(r, i)) first_enclosed_row_ = r;
    }
  }
  area_[kOutside] = ~std::uint32_t{0};
  return true;
}

}  // namespace plumbline::inline slicer
