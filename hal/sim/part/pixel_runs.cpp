#include "hal/sim/part/pixel_runs.hpp"

#include <bit>

#include "slicer/core/disjoint_sets.hpp"

namespace plumbline {

void PixelRuns::clear(std::uint32_t first_row) {
  first_row_ = first_row;
  runs_.clear();
  row_begin_.assign(1, 0);
}

void PixelRuns::end_of_row() { row_begin_.push_back(static_cast<std::uint32_t>(runs_.size())); }

void PixelRuns::find_white(ConstBitImage image) {
  const auto is_black = [&](std::uint32_t r) {
    const auto words = image.row(r);
    return std::all_of(words.begin(), words.end(), [](std::uint64_t word) { return word == 0; });
  };
  std::uint32_t first = 0;
  std::uint32_t end = image.rows();
  while (first < end && is_black(first)) ++first;
  while (end > first && is_black(end - 1)) --end;
  clear(first);
  for (std::uint32_t r = first; r < end; ++r) {
    std::uint64_t last = 0;  // the pixel to the left of the word
    std::uint32_t begin = 0;
    std::uint32_t column = 0;
    for (const std::uint64_t word : image.row(r)) {
      // A one where a pixel differs from its left neighbour: the runs' begins and ends in turn.
      for (std::uint64_t edges = word ^ (word << 1 | last); edges != 0; edges &= edges - 1) {
        const std::uint32_t at = column + static_cast<std::uint32_t>(std::countr_zero(edges));
        const bool white = (word >> (at - column) & 1U) != 0;
        if (white) {
          begin = at;
        } else {
          runs_.push_back({begin, at, 0});
        }
      }
      last = word >> 63;
      column += 64;
    }
    if (last != 0) runs_.push_back({begin, image.columns(), 0});
    end_of_row();
  }
  join_rows();
  number_regions();
}

void PixelRuns::find_black(const PixelRuns& white, std::uint32_t columns) {
  clear(white.first_row());
  runs_.push_back({0, 0, 0});  // the outside
  row_begin_[0] = 1;
  for (std::uint32_t r = white.first_row(); r < white.end_row(); ++r) {
    std::uint32_t at = 0;
    for (const Run& run : white.row(r)) {
      if (at < run.begin) runs_.push_back({at, run.begin, 0});
      at = run.end;
    }
    if (at < columns) runs_.push_back({at, columns, 0});
    end_of_row();
  }
  join_rows();
  join_outside(columns);
  number_regions();
}

void PixelRuns::join_rows() {
  parents_.resize(runs_.size());
  shared_.assign(runs_.size(), 0);
  DisjointSets sets{std::span(parents_)};
  sets.start_all();
  for (std::size_t r = 0; r + 1 < row_begin_.size(); ++r) {
    const std::uint32_t end = row_begin_[r + 1];
    std::uint32_t j = r > 0 ? row_begin_[r - 1] : row_begin_[r];
    for (std::uint32_t i = row_begin_[r]; i < end; ++i) {
      for (; j < row_begin_[r] && runs_[j].begin < runs_[i].end; ++j) {
        if (runs_[j].end > runs_[i].begin) {
          sets.unite(i, j);
          shared_[i] += std::min(runs_[i].end, runs_[j].end) - std::max(runs_[i].begin, runs_[j].begin);
        }
        if (runs_[j].end > runs_[i].end) break;
      }
    }
  }
}

void PixelRuns::join_outside(std::uint32_t columns) {
  DisjointSets sets{std::span(parents_)};
  const std::size_t rows = row_begin_.size() - 1;
  for (std::size_t r = 0; r < rows; ++r) {
    const bool border = r == 0 || r + 1 == rows;  // the rows beyond have no white
    for (std::uint32_t i = row_begin_[r]; i < row_begin_[r + 1]; ++i) {
      if (border || runs_[i].begin == 0 || runs_[i].end == columns) sets.unite(0, i);
    }
  }
}

void PixelRuns::number_regions() {
  const DisjointSets sets{std::span(parents_)};
  regions_.clear();
  for (std::uint32_t i = 0; i < runs_.size(); ++i) {
    Run& run = runs_[i];
    if (sets.is_root(i)) {
      run.region = static_cast<std::uint32_t>(regions_.size());
      regions_.emplace_back();
    } else {
      run.region = runs_[sets.root(i)].region;
    }
  }
  for (std::uint32_t r = 0; r + 1 < row_begin_.size(); ++r) {
    for (std::uint32_t i = row_begin_[r]; i < row_begin_[r + 1]; ++i) {
      const Run& run = runs_[i];
      Region& region = regions_[run.region];
      const std::uint32_t pixels = run.end - run.begin;
      region.pixels += pixels;
      // Above and below, less the sides that two of its rows share, which both have counted.
      region.sides_x += 2 * (pixels - shared_[i]);
      region.sides_y += 2;
      if (region.width == 0) {
        region.top_row = first_row_ + r;
        region.top_begin = run.begin;
      }
      if (pixels <= region.width) continue;
      region.width = pixels;
      region.row = first_row_ + r;
      region.column = run.begin + pixels / 2;
    }
  }
}

std::uint32_t PixelRuns::region_at(std::uint32_t column, std::uint32_t row) const {
  if (row < first_row() || row >= end_row()) return kNone;
  for (const Run& run : this->row(row)) {
    if (column < run.end) return column >= run.begin ? run.region : kNone;
  }
  return kNone;
}

}  // namespace plumbline
