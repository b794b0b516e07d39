#include "slicer/checks/island_rule.hpp"

#include <algorithm>
#include <optional>

#include "slicer/checks/layer_measures.hpp"
#include "slicer/core/bit_spans.hpp"
#include "slicer/supports/drawing/disc.hpp"

namespace plumbline::inline slicer {
namespace {

/// Calls visit(row, begin, end, tip) for each stretch of columns of a region that lies above a white region, `tip`.
template <class Visit>
void for_each_stretch_on_tips(const LayerRegions& regions, std::uint32_t region, const LayerRegions& below,
                              Visit visit) {
  regions.any_run_of(region, [&](std::uint32_t row, std::uint32_t at) {
    const LayerRegions::Run& run = regions.run(at);
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
  return layers.regions.any_run_of(region, [&](std::uint32_t row, std::uint32_t i) {
    const LayerRegions::Run& run = layers.regions.run(i);
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
                               fill(layers.scratch, row, begin, end, white);
                             });
  };
  draw(true);
  const bool any_far = layers.regions.any_run_of(region, [&](std::uint32_t row, std::uint32_t i) {
    const LayerRegions::Run& run = layers.regions.run(i);
    bool far = false;
    for_each_word(run.first, run.last + 1U, [&](std::uint32_t w, std::uint64_t bits) {
      far = far || reach_.near(layers.scratch, row, w, bits) != bits;
    });
    return far;
  });
  draw(false);
  return several && !any_far;
}

}  // namespace plumbline::inline slicer
