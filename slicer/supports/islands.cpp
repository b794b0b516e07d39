#include "slicer/supports/islands.hpp"

#include <algorithm>
#include <bit>

#include "slicer/core/bit_spans.hpp"

namespace plumbline::inline slicer {
namespace {

constexpr const char* kStage = "supports";

std::size_t most_runs(std::uint32_t columns) { return columns / 2 + 1; }

/// Columns [begin, end) of a row in which both images are white. Outside of the image all is black.
std::uint32_t count_both(ConstBitImage a, ConstBitImage b, std::int64_t row, std::uint32_t begin, std::uint32_t end) {
  if (row < 0 || row >= a.rows() || begin >= end) return 0;
  const auto line_a = a.row(static_cast<std::uint32_t>(row));
  const auto line_b = b.row(static_cast<std::uint32_t>(row));
  std::uint32_t count = 0;
  for_each_word(begin, end,
                [&](std::uint32_t w, std::uint64_t bits) { count += count_ones(line_a[w] & line_b[w] & bits); });
  return count;
}

}  // namespace

Expected<IslandFinder> IslandFinder::create(std::uint32_t columns, Arena& arena) {
  IslandFinder finder;
  for (auto* runs : {&finder.above_, &finder.here_}) {
    auto taken = arena.take_top<Run>(most_runs(columns), kStage);
    PLUMBLINE_TRY(taken);
    *runs = *taken;
  }
  for (auto* regions : {&finder.regions_, &finder.kept_}) {
    auto taken = arena.take_top<Region>(2 * most_runs(columns), kStage);
    PLUMBLINE_TRY(taken);
    *regions = *taken;
  }
  return finder;
}

std::size_t IslandFinder::bytes_needed(std::uint32_t columns) {
  return 2 * Arena::rounded(most_runs(columns) * sizeof(Run)) +
         2 * Arena::rounded(2 * most_runs(columns) * sizeof(Region));
}

void IslandFinder::read_runs(ConstBitImage mask, ConstBitImage below, ConstBitImage fresh, std::uint32_t row,
                             const Window& window) {
  if (open_ == 0 && row == window.row) may_be_weak_ = false;
  std::swap(above_, here_);
  above_count_ = open_ == 0 ? 0 : here_count_;
  here_count_ = 0;
  const auto line = fresh.row(row);
  for (std::uint32_t w = window.word; w < window.word_end; ++w) {
    std::uint64_t rest = line[w];
    while (rest != 0) {
      const auto first = static_cast<std::uint32_t>(std::countr_zero(rest));
      const auto length = static_cast<std::uint32_t>(std::countr_one(rest >> first));
      const std::uint32_t begin = w * 64 + first;
      if (here_count_ > 0 && here_[here_count_ - 1].end == begin) {
        here_[here_count_ - 1].end += length;  // continues from the word before
      } else {
        here_[here_count_++] = {begin, begin + length, 0};
      }
      rest = first + length >= 64 ? 0 : rest & ~std::uint64_t{0} << (first + length);
    }
  }
  for (std::uint32_t i = 0; i < here_count_; ++i) {
    Run& run = here_[i];
    run.region = open_ + i;
    const std::uint32_t before = run.begin - std::min(run.begin, 1U);
    const std::uint32_t after = std::min(run.end + 1, mask.columns());
    const std::int64_t r = row;
    const std::uint32_t sides = count_both(mask, below, r, before, after) +
                                count_both(mask, below, r - 1, run.begin, run.end) +
                                count_both(mask, below, r + 1, run.begin, run.end);
    regions_[run.region] = {run.region,
                            run.end - run.begin,
                            {run.begin + (run.end - run.begin) / 2, row, run.end - run.begin},
                            sides,
                            true};
  }
}

void IslandFinder::join_with_row_above() {
  Sets sets(regions_);
  std::uint32_t a = 0;
  std::uint32_t h = 0;
  while (a < above_count_ && h < here_count_) {
    if (above_[a].begin < here_[h].end && here_[h].begin < above_[a].end) {
      const auto [kept, joined] = sets.unite(above_[a].region, here_[h].region);
      if (joined != kept) {
        Region& to = regions_[kept];
        const Region& from = regions_[joined];
        const std::uint32_t pixels = to.middle.pixels + from.middle.pixels;
        if (from.width > to.width) {
          to.width = from.width;
          to.middle = from.middle;
        }
        to.middle.pixels = pixels;
        to.sides += from.sides;
        to.goes_on = true;
      }
    }
    if (above_[a].end <= here_[h].end) {
      ++a;
    } else {
      ++h;
    }
  }
}

void IslandFinder::keep_what_goes_on() {
  const Sets sets(regions_);
  std::uint32_t kept = 0;
  // The width of a copied region is no longer needed and holds its new number.
  for (std::uint32_t i = 0; i < here_count_; ++i) regions_[sets.root(here_[i].region)].goes_on = false;
  for (std::uint32_t i = 0; i < here_count_; ++i) {
    const std::uint32_t region = sets.root(here_[i].region);
    if (!regions_[region].goes_on) {
      regions_[region].goes_on = true;
      kept_[kept] = regions_[region];
      kept_[kept].parent = kept;
      kept_[kept].goes_on = false;
      regions_[region].width = kept++;
    }
    here_[i].region = regions_[region].width;
  }
  std::swap(regions_, kept_);
  open_ = kept;
}

}  // namespace plumbline::inline slicer
