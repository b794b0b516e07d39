#include "slicer/checks/stack_checker.hpp"

#include <algorithm>
#include <bit>

namespace plumbline::inline slicer {
namespace {

constexpr const char* kStage = "checks";

/// What erosion leaves has few runs.
constexpr LayerRegions::Settings kOverhangRegions{.runs_per_row = 8, .join_white_corners = true, .stage = kStage};

}  // namespace

Expected<StackChecker> StackChecker::create(const PrintGrid& grid, const CheckLimits& limits, Arena& arena) {
  auto regions = RegionTracker::create(grid, limits, arena);
  PLUMBLINE_TRY(regions);
  const auto slender = SlenderParts::create(grid, arena);
  PLUMBLINE_TRY(slender);
  StackChecker checker(grid, limits, *regions, *slender);
  for (BitImage* image : {&checker.below_mask_, &checker.fresh_, &checker.eroded_}) {
    const auto words = arena.take_top<std::uint64_t>(BitImage::words_needed(grid.columns, grid.rows), kStage);
    PLUMBLINE_TRY(words);
    *image = BitImage(*words, grid.columns, grid.rows);
    image->clear();
  }
  auto overhangs = LayerRegions::create(grid.columns, grid.rows, arena, kOverhangRegions);
  PLUMBLINE_TRY(overhangs);
  checker.overhangs_ = *overhangs;
  const auto widest = arena.take_top<std::uint32_t>(LayerRegions::most_runs(grid.rows, kOverhangRegions), kStage);
  PLUMBLINE_TRY(widest);
  checker.widest_ = *widest;
  if (limits.overhangs == OverhangRule::kNeedSupport) {
    const auto held = HeldArea::create(grid, {}, arena);
    PLUMBLINE_TRY(held);
    checker.held_ = *held;
    const std::uint32_t stride = checker.fresh_.stride();
    const auto marks = arena.take_top<std::uint64_t>(BitImage::words_needed(stride, grid.rows), kStage);
    PLUMBLINE_TRY(marks);
    checker.marks_ = BitImage(*marks, stride, grid.rows);
  }
  return checker;
}

std::size_t StackChecker::bytes_needed(const PrintGrid& grid, OverhangRule overhangs) {
  const std::size_t held =
      overhangs == OverhangRule::kNeedSupport
          ? HeldArea::bytes_needed(grid) +
                Arena::rounded(BitImage::words_needed((grid.columns + 63) / 64, grid.rows) * sizeof(std::uint64_t))
          : 0;
  return held + RegionTracker::bytes_needed(grid) + SlenderParts::bytes_needed() +
         3 * Arena::rounded(BitImage::words_needed(grid.columns, grid.rows) * sizeof(std::uint64_t)) +
         LayerRegions::bytes_needed(grid.rows, kOverhangRegions) +
         Arena::rounded(LayerRegions::most_runs(grid.rows, kOverhangRegions) * sizeof(std::uint32_t));
}

void StackChecker::next(ConstBitImage mask) {
  take(mask);
  check();
}

void StackChecker::take(ConstBitImage mask) { taken_ = compare_with_below(mask); }

void StackChecker::check_while(FunctionRef<void()> meanwhile) {
#pragma omp parallel
  {
#pragma omp single nowait
    check();
#pragma omp single nowait
    meanwhile();
  }
}

void StackChecker::check() {
  const SeenLayer& seen = taken_;
  measures_.next(below_mask_, seen, findings_);
  const RegionBox both = joined(seen.box, below_.box);
  const bool eroded = layer_ > 0 && find_overhangs(both);
  const bool needs_support = limits_.overhangs == OverhangRule::kNeedSupport && find_needing_support(both);
  regions_.next(below_mask_, eroded_, fresh_, findings_);
  if (needs_support) tell_needing_support();
  if (slender_.looks_at(layer_)) find_slender_parts();
  const auto blacken = [&](const BitImage& image) {
    for (std::uint32_t r = both.row; r < both.row_end; ++r) std::ranges::fill(image.row(r), std::uint64_t{0});
  };
  blacken(fresh_);
  if (eroded) blacken(eroded_);
  below_ = seen;
  ++layer_;
}

/// Finds the new pixels, and keeps the layer as the one below. Rows that are black in both cost one look at their words.
SeenLayer StackChecker::compare_with_below(ConstBitImage mask) {
  SeenLayer seen;
  seen.pixels = below_.pixels;
  RegionBox& box = seen.box;
  for (std::uint32_t r = 0; r < mask.rows(); ++r) {
    const auto line = mask.row(r);
    const bool is_black = is_blank(line);
    if (is_black && (r < below_.box.row || r >= below_.box.row_end)) continue;
    const auto below = below_mask_.row(r);
    const auto fresh = fresh_.row(r);
    for (std::uint32_t w = 0; w < line.size(); ++w) {
      const std::uint64_t word = line[w];
      if (word == below[w]) continue;
      fresh[w] = word & ~below[w];
      seen.pixels += count_ones(word);
      seen.pixels -= count_ones(below[w]);
      below[w] = word;
    }
    if (is_black) continue;
    std::uint32_t first = 0;
    while (line[first] == 0) ++first;
    std::uint32_t last = mask.stride() - 1;
    while (line[last] == 0) --last;
    box.row = std::min(box.row, r);
    box.row_end = r + 1;
    box.column = std::min(box.column, first * 64 + static_cast<std::uint32_t>(std::countr_zero(line[first])));
    const auto past = 64 - static_cast<std::uint32_t>(std::countl_zero(line[last]));
    box.column_end = std::max(box.column_end, last * 64 + past);
  }
  return seen;
}

/// @returns whether eroded_ has pixels
bool StackChecker::find_overhangs(const RegionBox& box) {
  if (box.empty() || erode_fresh(fresh_, box, limits_.overhang_reach, eroded_) == 0) return false;
  if (limits_.overhangs != OverhangRule::kEroded || !overhangs_.label(eroded_)) return true;
  for_each_region(overhangs_, widest_, [&](std::uint32_t region, bool white) {
    if (!white || !has_contour_area(region)) return;
    findings_.of(IssueKind::kOverhang).add(issue_at(IssueKind::kOverhang, layer_, overhangs_, widest_[region]));
  });
  return true;
}

/// Labels in overhangs_ what the support finder would put tips below, and leaves that in fresh_.
/// @returns whether there is any
bool StackChecker::find_needing_support(const RegionBox& box) {
  if (layer_ == 0) {
    held_.begin(below_mask_);
    return false;
  }
  if (box.empty()) return false;
  held_.next_layer(layer_, below_mask_, {box.row, box.row_end, box.column / 64, (box.column_end + 63) / 64});
  bool any = false;
  for (std::uint32_t r = box.row; r < box.row_end; ++r) {
    const auto marks = marks_.row(r);
    std::ranges::fill(marks, std::uint64_t{0});
    const auto fresh = fresh_.row(r);
    for (std::uint32_t w = box.column / 64; w < (box.column_end + 63) / 64; ++w) {
      if (fresh[w] == 0) continue;
      marks[w / 64] |= std::uint64_t{1} << (w % 64);
      any = true;
    }
  }
  if (!any) return false;
  held_.drop_what_is_near(fresh_, marks_);
  const auto is_left = [&](std::uint32_t row) { return !is_blank(fresh_.row(row)); };
  std::uint32_t row = box.row;
  while (row < box.row_end && !is_left(row)) ++row;
  return row < box.row_end && overhangs_.label(fresh_);
}

/// Tells of it where the mask's region is held: else an island is told. From here on it is held, as if a tip were there.
void StackChecker::tell_needing_support() {
  for_each_region(overhangs_, widest_, [&](std::uint32_t region, bool white) {
    if (!white) return;
    overhangs_.any_run_of(region, [&](std::uint32_t row, std::uint32_t i) {
      held_.add_run(row, overhangs_.run(i).first, overhangs_.run(i).last + 1U);
      return false;
    });
    const Issue issue = issue_at(IssueKind::kOverhang, layer_, overhangs_, widest_[region]);
    if (regions_.is_held(issue.column, issue.row)) findings_.of(IssueKind::kOverhang).add(issue);
  });
}

/// Overwrites fresh_ and overhangs_.
void StackChecker::find_slender_parts() {
  const auto add = [&](const Issue& section, const LayerRegions& regions, std::uint32_t region) {
    slender_.add(section, regions, region);
  };
  regions_.for_each_white(IssueKind::kNeedle, add);
  if (slender_.find_thin(below_mask_, taken_.box, fresh_) && overhangs_.label(fresh_)) {
    for_each_region(overhangs_, widest_, [&](std::uint32_t region, bool white) {
      if (white) add(issue_at(IssueKind::kThinWall, layer_, overhangs_, widest_[region]), overhangs_, region);
    });
  }
  slender_.end_look(layer_, findings_);
}

/// UVtools leaves out overhangs whose contours enclose less than a pixel's area. A contour runs through the middles of pixels, so
/// four pixels of which all are white add 1 to its area, three white ones add 1/2.
bool StackChecker::has_contour_area(std::uint32_t region) const {
  const auto white = [&](std::uint32_t c, std::uint32_t r) {
    return c < eroded_.columns() && r < eroded_.rows() && eroded_.at(c, r) ? 1U : 0U;
  };
  std::uint32_t halves = 0;
  return overhangs_.any_run_of(region, [&](std::uint32_t r, std::uint32_t i) {
    const LayerRegions::Run& run = overhangs_.run(i);
    for (std::uint32_t end = run.first; end <= run.last + 1U; ++end) {  // columns end - 1 and end
      const std::uint32_t left = end > 0 ? white(end - 1, r) + white(end - 1, r + 1) : 0;
      const std::uint32_t pixels = left + white(end, r) + white(end, r + 1);
      halves += pixels == 4 ? 2 : pixels == 3 ? 1 : 0;
      if (halves >= 2) return true;
    }
    return false;
  });
}

const StackFindings& StackChecker::finish() {
  measures_.finish(findings_);
  slender_.end_look(layer_, findings_);
  regions_.finish(findings_);
  return findings_;
}

}  // namespace plumbline::inline slicer
