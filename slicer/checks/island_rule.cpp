#include "slicer/checks/island_rule.hpp"

#include <algorithm>
#include <optional>

#include "slicer/checks/layer_measures.hpp"
#include "slicer/supports/drawing/disc.hpp"

namespace plumbline {
namespace {

/// @param visit  called with (row, run) until it returns true
/// @returns whether it did
template <class Visit>
bool any_run_of(const LayerRegions& regions, std::uint32_t region, Visit visit) {
  std::uint32_t left = regions.area(region);
  for (std::uint32_t r = regions.row_of(region); r < regions.rows() && left > 0; ++r) {
    for (std::uint32_t i = regions.row_begin(r); i < regions.row_begin(r + 1); ++i) {
      if (regions.region(i) != region) continue;
      const LayerRegions::Run& run = regions.run(i);
      left -= run.last + 1U - run.first;
      if (visit(r, run)) return true;
    }
  }
  return false;
}

/// Calls visit(row, begin, end, tip) for each stretch of columns of a region that lies above a white region, `tip`.
template <class Visit>
void for_each_stretch_on_tips(const LayerRegions& regions, std::uint32_t region, const LayerRegions& below,
                              Visit visit) {
  any_run_of(regions, region, [&](std::uint32_t row, const LayerRegions::Run& run) {
    for (std::uint32_t i = below.row_begin(row); i < below.row_begin(row + 1); ++i) {
      if (!below.white(row, i)) continue;
      const std::uint32_t begin = std::max(run.first, below.run(i).first);
      const std::uint32_t end = std::min(run.last, below.run(i).last) + 1U;
      if (begin < end) visit(row, begin, end, below.region(i));
    }
    return false;
  });
}

}  // namespace

Expected<IslandRule> IslandRule::create(const PrintGrid& grid, const CheckLimits& limits, Arena& arena) {
  IslandRule rule(grid, limits);
  const auto reach = Disc::create(PixelPitch(grid), nanometres(CheckLimits::kIslandTipsReach_mm), arena);
  PLUMBLINE_TRY(reach);
  rule.reach_ = *reach;
  return rule;
}

std::size_t IslandRule::bytes_needed(const PrintGrid& grid) {
  return Disc::bytes_needed(PixelPitch(grid), nanometres(CheckLimits::kIslandTipsReach_mm));
}

bool IslandRule::is_island(std::uint32_t region, std::uint32_t shared, Layers& layers) const {
  return overhangs(region, shared, layers) && !rests_on_tips(region, shared, layers);
}

/// UVtools' rule, which knows no tips.
bool IslandRule::overhangs(std::uint32_t region, std::uint32_t shared, const Layers& layers) const {
  const auto verdict = limits_.island.judge(layers.regions.area(region), shared);
  if (verdict != IslandShare::Verdict::kIslandIfOverhang) return verdict == IslandShare::Verdict::kIsland;
  return any_run_of(layers.regions, region, [&](std::uint32_t row, const LayerRegions::Run& run) {
    return count_in(layers.eroded.row(row), run.first, run.last + 1U) > 0;
  });
}

/// Whether a region touches the layer below in several places, and all of it is near to these.
bool IslandRule::rests_on_tips(std::uint32_t region, std::uint32_t shared, Layers& layers) const {
  if (scale_.mm2(shared) < limits_.island_tips_mm2) return false;
  if (std::uint64_t{shared} * limits_.island_tips_divisor < layers.regions.area(region)) return false;
  if (!layers.scratch_is_black) layers.scratch.clear();
  layers.scratch_is_black = true;
  std::optional<std::uint32_t> first;
  bool several = false;
  const auto draw = [&](bool white) {
    for_each_stretch_on_tips(layers.regions, region, layers.below,
                             [&](std::uint32_t row, std::uint32_t begin, std::uint32_t end, std::uint32_t tip) {
                               if (!first) first = tip;
                               several = several || tip != *first;
                               for_each_word(begin, end, [&](std::uint32_t w, std::uint64_t bits) {
                                 std::uint64_t& word = layers.scratch.row(row)[w];
                                 word = white ? word | bits : word & ~bits;
                               });
                             });
  };
  draw(true);
  const bool any_far = any_run_of(layers.regions, region, [&](std::uint32_t row, const LayerRegions::Run& run) {
    bool far = false;
    for_each_word(run.first, run.last + 1U, [&](std::uint32_t w, std::uint64_t bits) {
      far = far || reach_.near(layers.scratch, row, w, bits) != bits;
    });
    return far;
  });
  draw(false);
  return several && !any_far;
}

}  // namespace plumbline
