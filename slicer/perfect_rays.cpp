#include "slicer/perfect_rays.hpp"

#include <algorithm>
#include <cmath>

namespace plumbline {
namespace {

constexpr const char* kStage = "perfect rays";
constexpr std::uint32_t kMaxTileGaps = 64;
constexpr std::uint32_t kMaxDepths = 4096;

constexpr float kHalf = 0.5F;             ///< the surface, where there is none: halfway between outside and inside
constexpr float kSure = 0.2F;             ///< farther from half than this, a whole tile is judged by its centre
constexpr std::uint32_t kMaxLevels = 96;  ///< of an unsure gap
constexpr std::uint32_t kMaxProfile = 4 * 1024;  ///< winding numbers of a tile: four corners a level
constexpr std::uint32_t kBisections = 8;

}  // namespace

const char* to_string(RayDecision decision) {
  switch (decision) {
    case RayDecision::kOutside: return "outside";
    case RayDecision::kPerfect: return "perfect";
    case RayDecision::kRepaired: return "repaired";
    case RayDecision::kWinding: return "winding number";
    case RayDecision::kBase: return "base plane";
  }
  return "unknown";
}

std::size_t RayPerfecter::bytes_needed(std::uint32_t tile_capacity) {
  return RayGatherer::bytes_needed(tile_capacity) + RaySolver::bytes_needed() +
         Arena::rounded(kMaxTileGaps * sizeof(TileGap)) + Arena::rounded(kMaxProfile * sizeof(float)) +
         Arena::rounded(kMaxDepths * sizeof(float));
}

Expected<RayPerfecter> RayPerfecter::create(const Cloud& cloud, const KdTree2& tree, const WindingTree& winding,
                                            const PrintGrid& grid, float max_radius, std::uint32_t tile_capacity,
                                            const PerfectRaySettings& settings, Arena& arena) {
  auto gatherer = RayGatherer::create(cloud, tree, tile_capacity, max_radius, arena);
  if (!gatherer) return tl::unexpected<Error>(gatherer.error());
  auto solver = RaySolver::create(settings.intersections, arena);
  if (!solver) return tl::unexpected<Error>(solver.error());
  auto gaps = arena.take_top<TileGap>(kMaxTileGaps, kStage);
  if (!gaps) return tl::unexpected<Error>(gaps.error());
  auto profile = arena.take_top<float>(kMaxProfile, kStage);
  if (!profile) return tl::unexpected<Error>(profile.error());
  auto depths = arena.take_top<float>(kMaxDepths, kStage);
  if (!depths) return tl::unexpected<Error>(depths.error());

  RayPerfecter perfecter;
  perfecter.gatherer_ = *gatherer;
  perfecter.solver_ = *solver;
  perfecter.winding_ = &winding;
  perfecter.grid_ = grid;
  perfecter.settings_ = settings;
  perfecter.tile_gaps_ = *gaps;
  perfecter.profile_ = *profile;
  perfecter.depths_ = *depths;
  perfecter.top_ = static_cast<float>(grid.layers) * grid.layer_height_mm;
  perfecter.floor_ = std::max(0.0F, winding.base());
  return perfecter;
}

RayPerfecter::Verdict RayPerfecter::winding_verdict(float w) const {
  if (w > kHalf + kSure) return Verdict::kInside;
  return w < kHalf - kSure ? Verdict::kOutside : Verdict::kUnsure;
}

RayPerfecter::Verdict RayPerfecter::judge_column(std::uint32_t level) {
  Verdict& verdict = column_verdicts_[level];
  if (verdict == Verdict::kUnknown) {
    verdict = winding_verdict((*winding_)({column_centre_[0], column_centre_[1], level_height(level)}));
  }
  return verdict;
}

RayPerfecter::Verdict RayPerfecter::judge_centre(float low, float high) {
  // Both ends count: a gap that is air for its first tenth and solid above must not pass for solid.
  const Vec2f centre = 0.5F * (tile_low_ + tile_high_);
  const Verdict verdict = winding_verdict((*winding_)({centre[0], centre[1], low}));
  if (verdict == Verdict::kUnsure || winding_verdict((*winding_)({centre[0], centre[1], high})) != verdict) {
    return Verdict::kUnsure;
  }
  const auto first = static_cast<std::uint32_t>(std::max(low, 0.0F) / top_ * kLevels);
  for (std::uint32_t level = first; level < kLevels && level_height(level) < high; ++level) {
    if (level_height(level) > low && judge_column(level) != verdict) return Verdict::kUnsure;
  }
  return verdict;
}

void RayPerfecter::add_tile_gap(float low, float high) {
  if (!(high > low) || tile_gap_count_ == kMaxTileGaps) return;
  TileGap gap{low, high, judge_centre(low, high), 0, profile_size_};
  if (gap.verdict == Verdict::kUnsure) {
    // The winding number changes slowly where no point is near: the tile's corners tell it for all of its rays.
    const std::uint32_t room = (kMaxProfile - profile_size_) / 4;
    const float side = std::max(tile_high_[0] - tile_low_[0], grid_.layer_height_mm);
    const float levels = std::min({std::ceil((high - low) / side) + 1, 1.0F * kMaxLevels, static_cast<float>(room)});
    if (levels < 2) return;
    gap.levels = static_cast<std::uint32_t>(levels);
    for (std::uint32_t k = 0; k < gap.levels; ++k) {
      const float z = gap.level(k);
      profile_[profile_size_++] = (*winding_)({tile_low_[0], tile_low_[1], z});
      profile_[profile_size_++] = (*winding_)({tile_high_[0], tile_low_[1], z});
      profile_[profile_size_++] = (*winding_)({tile_low_[0], tile_high_[1], z});
      profile_[profile_size_++] = (*winding_)({tile_high_[0], tile_high_[1], z});
    }
  }
  tile_gaps_[tile_gap_count_++] = gap;
}

void RayPerfecter::begin_tile(std::uint32_t column, std::uint32_t row) {
  const auto last_column = static_cast<float>(std::min(grid_.columns, column + RayGatherer::kTile) - 1);
  const auto last_row = static_cast<float>(std::min(grid_.rows, row + RayGatherer::kTile) - 1);
  const Vec2f low((static_cast<float>(column) + 0.5F) * grid_.pitch_x_mm,
                  (static_cast<float>(row) + 0.5F) * grid_.pitch_y_mm);
  const Vec2f high((last_column + 0.5F) * grid_.pitch_x_mm, (last_row + 0.5F) * grid_.pitch_y_mm);
  gatherer_.gather(low, high);

  tile_low_ = low;
  tile_high_ = high;
  // What no point of the tile reaches, from the base plane to the top.
  tile_gap_count_ = 0;
  profile_size_ = 0;
  levels_.fill({});
  const std::uint32_t column_middle = column / kColumnSide * kColumnSide + kColumnSide / 2;
  const std::uint32_t row_middle = row / kColumnSide * kColumnSide + kColumnSide / 2;
  const Vec2f column_centre(static_cast<float>(column_middle) * grid_.pitch_x_mm,
                            static_cast<float>(row_middle) * grid_.pitch_y_mm);
  if (column_centre != column_centre_) column_verdicts_.fill(Verdict::kUnknown);
  column_centre_ = column_centre;
  float reached = floor_;
  for (std::uint32_t t = 0; t < gatherer_.tile_points(); ++t) {
    const float radius = gatherer_.tile_radius(t);
    const float depth = gatherer_.tile_depth(t);
    // Depths ascend; a wide support that reaches down into a gap only makes that gap a little longer than it is.
    if (depth - radius > reached) add_tile_gap(reached, depth - radius);
    reached = std::max(reached, depth + radius);
  }
  add_tile_gap(reached, top_);
}

bool RayPerfecter::alternates(const RaySurface& surface) const {
  bool inside = false;
  for (const Band& band : surface.bands) {
    if (band.inside_at_low != inside) return false;
    inside = band.inside_at_high;
  }
  return !inside;
}

float RayPerfecter::profile(const TileGap& gap, std::uint32_t level, float x, float y) const {
  const Vec2f side = tile_high_ - tile_low_;
  const float u = side[0] > 0 ? (x - tile_low_[0]) / side[0] : 0;
  const float v = side[1] > 0 ? (y - tile_low_[1]) / side[1] : 0;
  const float* w = &profile_[gap.first + std::size_t{4} * level];
  return (w[0] * (1 - u) + w[1] * u) * (1 - v) + (w[2] * (1 - u) + w[3] * u) * v;
}

void RayPerfecter::bisect(float x, float y, float low, float high, bool inside_at_low) {
  for (std::uint32_t i = 0; i < kBisections && high - low > grid_.layer_height_mm; ++i) {
    const float middle = 0.5F * (low + high);
    (((*winding_)({x, y, middle}) > kHalf) == inside_at_low ? low : high) = middle;
  }
  emit(0.5F * (low + high));
}

RayPerfecter::Gap RayPerfecter::trace_tile_gap(const TileGap& tile_gap, float x, float y) {
  if (tile_gap.verdict != Verdict::kUnsure) {
    const bool inside = tile_gap.verdict == Verdict::kInside;
    return {inside, inside};
  }
  float before = profile(tile_gap, 0, x, y);
  Gap gap{before > kHalf, before > kHalf};
  for (std::uint32_t k = 1; k < tile_gap.levels; ++k) {
    const float here = profile(tile_gap, k, x, y);
    if ((here > kHalf) != gap.inside_at_high) {
      const float share = (kHalf - before) / (here - before);
      emit(tile_gap.level(k - 1) + share * (tile_gap.level(k) - tile_gap.level(k - 1)));
      gap.inside_at_high = here > kHalf;
    }
    before = here;
  }
  return gap;
}

bool RayPerfecter::level_inside(std::uint32_t level, float x, float y) {
  LevelSet& set = levels_[ray_block_];
  const std::uint64_t bit = std::uint64_t{1} << level;
  if ((set.known & bit) == 0) {
    set.known |= bit;
    if ((*winding_)({x, y, level_height(level)}) > kHalf) set.inside |= bit;
  }
  return (set.inside & bit) != 0;
}

RayPerfecter::Gap RayPerfecter::decide_gap(float x, float y, float low, float high, bool below, bool above) {
  const std::uint32_t depths_before = depth_count_;
  GapWalk walk{x, y, low, below};
  for (const TileGap& tile_gap : tile_gaps_.first(tile_gap_count_)) {
    if (tile_gap.high <= low || tile_gap.low >= high) continue;
    walk_levels(walk, tile_gap.low);
    const Gap part = trace_tile_gap(tile_gap, x, y);
    step(walk, tile_gap.low, part.inside_at_low);
    walk.at = tile_gap.high;
    walk.inside = part.inside_at_high;
  }
  walk_levels(walk, high);
  // Both shores know better than a sum over the whole cloud where nothing was asked between them.
  if (!walk.begun) {
    if (below != above) {
      bisect(x, y, low, high, below);
      used_winding_ = true;
    }
    return {below, above};
  }
  // The last place asked and the upper shore disagree: an unseen sheet between them, or a shore that faces the wrong way.
  if (walk.inside != above && ((*winding_)({x, y, high}) > kHalf) == above) step(walk, high, above);
  if (depth_count_ != depths_before || walk.inside_at_low != below || walk.inside != above) used_winding_ = true;
  return {walk.inside_at_low, walk.inside};
}

void RayPerfecter::step(GapWalk& walk, float z, bool inside) {
  if (!walk.begun) {
    walk.begun = true;
    walk.inside_at_low = inside;
    // The first place asked and the lower shore disagree, as above.
    if (inside != walk.inside && ((*winding_)({walk.x, walk.y, walk.at}) > kHalf) == walk.inside) {
      walk.inside_at_low = walk.inside;
      bisect(walk.x, walk.y, walk.at, z, walk.inside);
    }
  } else if (inside != walk.inside) {
    bisect(walk.x, walk.y, walk.at, z, walk.inside);
  }
  walk.at = z;
  walk.inside = inside;
}

void RayPerfecter::walk_levels(GapWalk& walk, float high) {
  const float spacing = top_ / kLevels;
  for (auto level = static_cast<std::uint32_t>(std::max(walk.at, 0.0F) / spacing); level < kLevels; ++level) {
    const float z = level_height(level);
    if (z >= high) break;
    if (z > walk.at) step(walk, z, level_inside(level, walk.x, walk.y));
  }
}

void RayPerfecter::emit(float depth) {
  if (depth_count_ < depths_.size()) depths_[depth_count_++] = std::max(depth, floor_);
}

void RayPerfecter::cross_band(const RaySurface& surface, const Band& band, bool from, bool to) {
  std::uint32_t first = band.first;
  std::uint32_t last = band.last;
  const bool wrong_low = band.inside_at_low != from;
  const bool wrong_high = band.inside_at_high != to;
  if (wrong_low && wrong_high) {
    // Inside out: a patch that faces the wrong way. Its sheet stands where it is; a pair of sheets is left out.
    if (from == to) first = last;
  } else if (wrong_low) {
    if (first == last) {
      emit(band.low);
    } else {
      ++first;
    }
  } else if (wrong_high) {
    if (first == last) {
      emit(band.high);
    } else {
      --last;
    }
  }
  for (std::uint32_t i = first; i < last; ++i) emit(surface.intersections[i].depth);
}

void RayPerfecter::drop_thin_stretches() {
  while (depth_count_ > kMaxCrossings) {
    std::uint32_t thinnest = 0;
    for (std::uint32_t i = 1; i + 1 < depth_count_; ++i) {
      if (depths_[i + 1] - depths_[i] < depths_[thinnest + 1] - depths_[thinnest]) thinnest = i;
    }
    std::copy(depths_.begin() + thinnest + 2, depths_.begin() + depth_count_, depths_.begin() + thinnest);
    depth_count_ -= 2;
  }
}

PerfectRay RayPerfecter::ray(std::uint32_t column, std::uint32_t row) {
  const float x = (static_cast<float>(column) + 0.5F) * grid_.pitch_x_mm;
  const float y = (static_cast<float>(row) + 0.5F) * grid_.pitch_y_mm;
  constexpr std::uint32_t kTile = RayGatherer::kTile;
  ray_block_ = row % kTile / kBlock * (kTile / kBlock) + column % kTile / kBlock;
  const RayPoints& points = gatherer_.points_of_ray(x, y);
  RaySurface surface = solver_.solve(gatherer_, points);
  RayDecision decision = RayDecision::kPerfect;
  if (!alternates(surface)) {
    surface = solver_.solve_uniform(gatherer_, points, settings_.repair_spacing);
    decision = RayDecision::kRepaired;
  }

  depth_count_ = 0;
  used_winding_ = false;
  bool base = false;
  bool inside = false;  // MLS sign below the gap
  float reached = floor_;
  Gap gap{false, false};
  for (std::size_t b = 0; b <= surface.bands.size(); ++b) {
    const bool last = b == surface.bands.size();
    const Band* band = last ? nullptr : &surface.bands[b];
    const bool above = !last && band->inside_at_low;
    const float high = last ? top_ : band->low;
    const bool was_inside = gap.inside_at_high;
    if (high > reached) {
      gap = decide_gap(x, y, reached, high, inside, above);
    } else {
      gap = {above, above};  // the band starts at or below the base plane
    }
    if (b == 0) {
      base = gap.inside_at_low;
      if (base) emit(floor_);
    } else {
      cross_band(surface, surface.bands[b - 1], was_inside, gap.inside_at_low);
    }
    if (!last) {
      inside = band->inside_at_high;
      reached = std::max(reached, band->high);
    }
  }
  if (gap.inside_at_high) emit(top_);

  // Gaps have emitted before the bands below them, and neighbouring bands may stand in each other's way by a rounding: the
  // order is what makes crossings alternate.
  std::sort(depths_.begin(), depths_.begin() + depth_count_);
  drop_thin_stretches();
  if (used_winding_) decision = RayDecision::kWinding;
  if (base && depth_count_ > 0) decision = RayDecision::kBase;
  if (depth_count_ == 0) decision = RayDecision::kOutside;
  return {depths_.first(depth_count_ / 2 * 2), decision};
}

}  // namespace plumbline
