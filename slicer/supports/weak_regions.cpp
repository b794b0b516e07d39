#include "slicer/supports/weak_regions.hpp"

#include <algorithm>

#include "slicer/core/bit_spans.hpp"

namespace plumbline::inline slicer {
namespace {

constexpr const char* kStage = "supports";
constexpr LayerRegions::Settings kRegions{.runs_per_row = 4, .join_white_corners = false, .stage = kStage};

}  // namespace

Expected<WeakRegions> WeakRegions::create(std::uint32_t columns, std::uint32_t rows, Arena& arena) {
  WeakRegions weak;
  auto regions = LayerRegions::create(columns, rows, arena, kRegions);
  PLUMBLINE_TRY(regions);
  weak.regions_ = *regions;
  const auto held = arena.take_top<std::uint32_t>(LayerRegions::most_runs(rows, kRegions), kStage);
  PLUMBLINE_TRY(held);
  weak.held_ = *held;
  return weak;
}

std::size_t WeakRegions::bytes_needed(std::uint32_t rows) {
  return LayerRegions::bytes_needed(rows, kRegions) +
         Arena::rounded(LayerRegions::most_runs(rows, kRegions) * sizeof(std::uint32_t));
}

void WeakRegions::look_at(ConstBitImage mask, ConstBitImage below, std::span<const Tip> tips) {
  any_ = regions_.label(mask);
  if (!any_) return;
  std::fill_n(held_.begin(), regions_.run_count(), 0U);
  regions_.for_each_white_run([&](std::uint32_t row, std::uint32_t i) {
    const LayerRegions::Run& run = regions_.run(i);
    std::uint32_t& held = held_[regions_.region(i)];
    for_each_word(run.first, run.last + 1U,
                  [&](std::uint32_t w, std::uint64_t bits) { held += count_ones(below.row(row)[w] & bits); });
  });
  for (const Tip& tip : tips) {
    // Of a white pixel, or of the outside.
    held_[regions_.region(regions_.run_at(tip.column, tip.row))] = LayerRegions::kNone;
  }
}

bool WeakRegions::is_weak(std::uint32_t region) const {
  const std::uint32_t held = held_[region];
  return held > 0 && IslandShare{}.judge(regions_.area(region), held) == IslandShare::Verdict::kIsland;
}

WeakRegions::Place WeakRegions::place_in(std::uint32_t region, ConstBitImage mask, ConstBitImage below) const {
  Place place{.column = 0, .row = 0, .pixels = regions_.area(region)};
  std::uint32_t widest = 0;
  regions_.any_run_of(region, [&](std::uint32_t row, std::uint32_t i) {
    const LayerRegions::Run& run = regions_.run(i);
    std::uint32_t begin = run.first;
    for (std::uint32_t c = run.first; c <= run.last + 1U; ++c) {
      if (c <= run.last && mask.at(c, row) && !below.at(c, row)) continue;
      if (c - begin > widest) {
        widest = c - begin;
        place.column = begin + widest / 2;
        place.row = row;
      }
      begin = c + 1;
    }
    return false;
  });
  return place;
}

}  // namespace plumbline::inline slicer
