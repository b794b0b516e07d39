#include "slicer/supports/support_finder.hpp"

#include <algorithm>
#include <bit>
#include <cmath>
#include <tuple>

#include "slicer/layers/layer_stream.hpp"
#include "slicer/layers/rrep_edit.hpp"
#include "slicer/supports/bracing.hpp"
#include "slicer/supports/feet.hpp"
#include "slicer/supports/obstacles.hpp"
#include "slicer/supports/raft.hpp"
#include "slicer/supports/routing.hpp"
#include "slicer/supports/stand.hpp"
#include "slicer/supports/tips.hpp"
#include "slicer/supports/window.hpp"

namespace plumbline::inline slicer {
namespace {

constexpr const char* kStage = "supports";

// A tip has tip, head, bridge, pillar, base, disc and bar of the raft; the rest is for braces, helpers, and small grids.
constexpr std::uint32_t kStrutsPerTip = 8;
constexpr std::uint32_t kContactsPerTip = 8;
constexpr std::uint32_t kHelperShare = 2;  ///< pillars are at most so many times the tips

/// Largest lift, mm, for the memory of its layers.
constexpr double kMostLift_mm = 60;
static_assert([] {
  double most = 0;
  for (const SupportField& field : kSupportFields) {
    if (field.key == "support_object_elevation" || field.key == "pad_wall_thickness") most += field.high;
  }
  return most;
}() <= kMostLift_mm);

/// Pixels of specks that are left out; a speck has some tens, and a noisy scan some tens of specks.
constexpr std::size_t kMostSpeckPixels = 8192;

struct Scratch {
  std::span<Tip> tips;
  std::span<SpeckPixel> specks;
  std::span<Strut> struts;
  std::span<Pillar> pillars;
  std::span<StrutContact> contacts;
  std::span<double> nearest;
  std::span<std::uint32_t> to;

  static Expected<Scratch> take(const PrintGrid& grid, Arena& arena) {
    const std::size_t most = most_tips(grid);
    Scratch scratch;
    const auto take_one = [&]<class T>(std::span<T>& span, std::size_t count) -> Status {
      const auto taken = arena.take_top<T>(count, kStage);
      PLUMBLINE_TRY(taken);
      span = *taken;
      return {};
    };
    PLUMBLINE_TRY(take_one(scratch.tips, most));
    PLUMBLINE_TRY(take_one(scratch.specks, kMostSpeckPixels));
    PLUMBLINE_TRY(take_one(scratch.struts, most_struts(grid)));
    PLUMBLINE_TRY(take_one(scratch.pillars, kHelperShare * most));
    PLUMBLINE_TRY(take_one(scratch.contacts, kContactsPerTip * most));
    PLUMBLINE_TRY(take_one(scratch.nearest, kHelperShare * most));
    PLUMBLINE_TRY(take_one(scratch.to, kHelperShare * most));
    return scratch;
  }
  static std::size_t bytes_needed(const PrintGrid& grid) {
    const std::size_t most = most_tips(grid);
    return Arena::rounded(most * sizeof(Tip)) + Arena::rounded(kMostSpeckPixels * sizeof(SpeckPixel)) +
           Arena::rounded(most_struts(grid) * sizeof(Strut)) + Arena::rounded(kHelperShare * most * sizeof(Pillar)) +
           Arena::rounded(kContactsPerTip * most * sizeof(StrutContact)) +
           Arena::rounded(kHelperShare * most * sizeof(double)) +
           Arena::rounded(kHelperShare * most * sizeof(std::uint32_t));
  }
};

/// Highest first, so that lower tips can hang on the pillars of higher ones.
void sort_for_routing(std::span<Tip> tips) {
  std::sort(tips.begin(), tips.end(), [](const Tip& a, const Tip& b) {
    return std::tuple(b.layer, a.row, a.column) < std::tuple(a.layer, b.row, b.column);
  });
}

Status build(std::span<Tip> tips, const SupportSettings& settings, double raft_mm, const Obstacles& obstacles,
             const Scratch& scratch, StrutList& list, SupportCounts& counts) {
  Routing routing(settings, raft_mm, obstacles, list);
  sort_for_routing(tips);
  for (const Tip& tip : tips) {
    const auto led = routing.route(tip);
    PLUMBLINE_TRY(led);
  }
  Bracing bracing(settings, raft_mm, obstacles, list, scratch.contacts);
  PLUMBLINE_TRY(bracing.brace_all());
  if (raft_mm > 0) PLUMBLINE_TRY(add_raft(settings, list, scratch.nearest, scratch.to));
  const RouteCounts& routes = routing.counts();
  counts.on_plate = routes.on_plate;
  counts.on_object = routes.on_object;
  counts.on_supports = routes.on_supports;
  counts.unreached_islands = routes.unreached_islands;
  counts.unreached_overhangs = routes.unreached_overhangs;
  counts.light = routes.light;
  counts.medium = routes.medium;
  counts.heavy = routes.heavy;
  counts.braces = bracing.counts().braces;
  counts.helpers = bracing.counts().helpers;
  counts.unbraced = bracing.counts().unbraced;
  counts.longest_free_mm = bracing.counts().longest_free_mm;
  return {};
}

void count_tips(std::span<const Tip> tips, const PrintGrid& grid, SupportCounts& counts) {
  std::uint32_t load = 0;
  for (const Tip& tip : tips) {
    ++(tip.island ? counts.islands : counts.overhangs);
    load = std::max(load, tip.load);
  }
  counts.largest_load_mm2 = load * static_cast<double>(grid.pitch_x_mm) * static_cast<double>(grid.pitch_y_mm);
}

/// What leave_out() toggles, and adds to the R-Rep where opening has removed from the mask below what its section has.
constexpr std::size_t kMostSpeckCrossings = 2 * kMostSpeckPixels;

/// Removes specks from the R-Rep.
Status leave_out(std::span<const SpeckPixel> specks, RRep& rrep, Arena& arena) {
  if (specks.empty()) return {};
  const ArenaScope scope(arena);
  const auto toggles = arena.take_top<RRepToggle>(2 * specks.size(), kStage);
  PLUMBLINE_TRY(toggles);
  std::size_t count = 0;
  for (const SpeckPixel& speck : specks) {
    if (!speck.in_section) continue;
    (*toggles)[count++] = {speck.layer, speck.pixel};
    (*toggles)[count++] = {speck.layer + 1U, speck.pixel};
  }
  return toggle_crossings(rrep, toggles->first(count), arena);
}

/// Removes the layers at the top that held nothing but specks.
Status trim_top(std::span<const SpeckPixel> specks, RRep& rrep, Arena& arena) {
  const auto is_top = [&](const SpeckPixel& speck) { return speck.layer + 1U == rrep.grid.layers; };
  if (std::ranges::none_of(specks, is_top)) return {};
  auto empty = find_empty_layers(rrep, arena);
  PLUMBLINE_TRY(empty);
  if (empty->below < rrep.grid.layers) empty->below = 0;  // else nothing is left, which is refused
  PLUMBLINE_TRY(trim_empty_layers(rrep, arena, *empty));
  return {};
}

/// @param tips     of `rrep`, which is lifted
/// @param scratch  for the struts
Expected<std::span<Strut>> find_struts(const RRep& rrep, std::span<Tip> tips, const SupportSettings& settings,
                                       const Scratch& scratch, Arena& arena, SupportCounts& counts) {
  StrutList list(rrep.grid, scratch.struts, scratch.pillars);
  {
    const ArenaScope scope(arena);
    if (!tips.empty()) {
      count_tips(tips, rrep.grid, counts);
      const auto obstacles = Obstacles::create(rrep, nanometres(Routing::clearance(settings)), arena);
      PLUMBLINE_TRY(obstacles);
      const double raft_mm = counts.lifted > 0 ? settings.pad_wall_thickness : 0;
      PLUMBLINE_TRY(build(tips, settings, raft_mm, *obstacles, scratch, list, counts));
    }
  }
  const auto pads = add_feet(rrep, list, arena);
  PLUMBLINE_TRY(pads);
  counts.pads = *pads;
  const auto struts = list.struts();
  std::sort(struts.begin(), struts.end(), [](const Strut& a, const Strut& b) {
    const auto key = [](const Strut& s) {
      return std::tuple(s.first, s.end, s.row0, s.column0, s.row1, s.column1, s.radius0, s.radius1, s.kind, s.lies);
    };
    return key(a) < key(b);
  });
  return struts;
}

/// Applies points_density_relative: with four times the tips they are half as far apart.
SupportSettings at_density(SupportSettings settings) {
  const double density = settings.points_density_relative / 100;
  settings.area_per_tip /= density;
  settings.overhang_span = std::min(kLongestSpan, settings.overhang_span / std::sqrt(density));
  return settings;
}

Expected<Supports> find(RRep& rrep, const SupportSettings& settings, std::uint32_t most_layers, Arena& arena,
                        ProgressSink* progress, SupportCounts& counts, const CureModel& cure,
                        const AdaptiveLayers& adaptive) {
  const auto stand = choose_stand(rrep, settings, most_layers, arena);
  PLUMBLINE_TRY(stand);
  RRep stood = rrep;
  PLUMBLINE_TRY(stand_object(stood, {.sunk = stand->sunk, .lifted = 0}, arena));
  counts.lifted = stand->lifted;
  counts.sunk = stand->sunk;
  counts.flat = stand->flat;
  if (adaptive.wanted()) {
    const auto steps = choose_steps(stood, adaptive, stand->lifted, cure, arena);
    PLUMBLINE_TRY(steps);
    counts.steps = *steps;
  }
  if (cure.is_known()) {
    const auto bleed = correct_bleed(stood, cure, stand->lifted, arena, counts.steps);
    PLUMBLINE_TRY(bleed);
    counts.bleed = *bleed;
  } else if (adaptive.wanted()) {
    take_steps(stood, counts.steps, stand->lifted);
  }
  const ArenaScope scope(arena);
  const auto scratch = Scratch::take(stood.grid, arena);
  PLUMBLINE_TRY(scratch);
  const auto needed =
      find_tips(stood, stand->lifted, at_density(settings), scratch->tips, scratch->specks, arena, progress);
  PLUMBLINE_TRY(needed);
  counts.specks = needed->speck_count;
  counts.missed = needed->missed;
  counts.added = static_cast<std::uint32_t>(settings.added.all().size()) -
                 static_cast<std::uint32_t>(std::popcount(needed->missed));
  counts.specks_mm3 = static_cast<double>(needed->specks.size()) * static_cast<double>(stood.grid.pitch_x_mm) *
                      static_cast<double>(stood.grid.pitch_y_mm) * static_cast<double>(stood.grid.layer_height_mm);
  if (!adaptive.wanted() && (stood.is_exact || (needed->specks.empty() && !counts.bleed))) {
    counts.lost_pixels = stand->sunk_pixels + needed->specks.size() + (counts.bleed ? counts.bleed->pixels : 0);
  }
  PLUMBLINE_TRY(leave_out(needed->specks, stood, arena));
  PLUMBLINE_TRY(trim_top(needed->specks, stood, arena));
  PLUMBLINE_TRY(stand_object(stood, {.sunk = 0, .lifted = stand->lifted}, arena));
  const auto found = find_struts(stood, needed->tips, settings, *scratch, arena, counts);
  PLUMBLINE_TRY(found);
  const auto list = arena.take_bottom<Strut>(found->size(), kStage);
  PLUMBLINE_TRY(list);
  std::copy(found->begin(), found->end(), list->begin());
  rrep = stood;
  return Supports{*list, PixelPitch(rrep.grid)};
}

std::size_t bytes_needed(const PrintGrid& grid, const Window& window, double most_lift_mm) {
  const auto lift = static_cast<std::size_t>(most_lift_mm / static_cast<double>(grid.layer_height_mm)) + 2;
  const std::size_t layers = std::min<std::size_t>(grid.layers + lift, PrintGrid::kMaxLayers) + 1;
  const std::size_t without_specks =
      Arena::rounded(kMostSpeckCrossings * sizeof(std::uint32_t)) +
      std::max({Arena::rounded(kMostSpeckCrossings * sizeof(RRepToggle)),
                LayerStream::bytes_needed(grid) + Obstacles::bytes_needed(grid, most_lift_mm), add_feet_bytes(grid),
                Arena::rounded(most_struts(grid) * sizeof(Strut))});
  return Arena::rounded(layers * sizeof(std::uint32_t)) + Scratch::bytes_needed(grid) +
         std::max(find_tips_bytes(grid, window), without_specks);
}

}  // namespace

Expected<Supports> find_supports(RRep& rrep, const SupportSettings& settings, std::uint32_t most_layers, Arena& arena,
                                 ProgressSink* progress, SupportCounts& counts, const CureModel& cure,
                                 const AdaptiveLayers& adaptive) {
  const std::size_t bottom = arena.bottom_mark();
  counts = {};
  auto supports = find(rrep, settings, most_layers, arena, progress, counts, cure, adaptive);
  if (!supports) {
    arena.release_bottom(bottom);
    counts = {};
  }
  return supports;
}

std::uint32_t most_struts(const PrintGrid& grid) { return kStrutsPerTip * most_tips(grid); }

std::size_t find_supports_bytes(const PrintGrid& grid) {
  return bytes_needed(grid, {0, grid.rows, 0, (grid.columns + 63) / 64}, kMostLift_mm);
}

std::size_t find_supports_bytes(const RRep& rrep, const SupportSettings& settings) {
  return bytes_needed(rrep.grid, window_of(rrep), lift_mm(settings));
}

}  // namespace plumbline::inline slicer
