#include "slicer/checks/layer_measures.hpp"

#include <algorithm>

namespace plumbline::inline slicer {
namespace {

/// The layer height is a float, so heights may be off by this share.
constexpr double kRounding = 1e-6;

/// Adds a layer to an issue that may have many; the largest one gives its place.
void extend(Issue& issue, const Issue& layer) {
  if (issue.voxels == 0) {
    issue = layer;
    return;
  }
  const std::uint64_t voxels = issue.voxels + layer.voxels;
  const std::uint32_t first = issue.first_layer;
  if (layer.pixels > issue.pixels) issue = layer;
  issue.voxels = voxels;
  issue.first_layer = first;
  issue.last_layer = layer.last_layer;
}

}  // namespace

std::uint64_t count_in(std::span<const std::uint64_t> line, std::uint32_t begin, std::uint32_t end) {
  std::uint64_t sum = 0;
  for (std::uint32_t c = begin; c < end;) {
    const std::uint32_t bit = c % 64;
    const std::uint32_t taken = std::min(end - c, 64 - bit);
    const std::uint64_t ones = taken == 64 ? ~std::uint64_t{0} : (std::uint64_t{1} << taken) - 1;
    sum += count_ones(line[c / 64] >> bit & ones);
    c += taken;
  }
  return sum;
}

void LayerMeasures::next(ConstBitImage mask, const SeenLayer& seen, StackFindings& findings) {
  check_areas(seen, findings);
  check_bounds(mask, seen.box);
  pixels_below_ = seen.pixels;
  findings.voxels += seen.pixels;
  findings.layers = ++layer_;
}

void LayerMeasures::check_areas(const SeenLayer& seen, StackFindings& findings) {
  const auto add = [&](const Issue& issue) { findings.of(issue.kind).add(issue); };
  const auto found = [&](IssueKind kind, std::uint64_t pixels) {
    return Issue{kind,
                 layer_,
                 layer_,
                 layer_,
                 (seen.box.column + seen.box.column_end) / 2,
                 (seen.box.row + seen.box.row_end) / 2,
                 pixels,
                 pixels};
  };
  const std::uint64_t pixels = seen.pixels;
  if (layer_ == 0) {
    findings.first_layer_pixels = pixels;
    if (pixels > 0 && scale_.mm2(pixels) < limits_.first_layer_mm2) add(found(IssueKind::kFirstLayerArea, pixels));
  }
  if (pixels > findings.peel_pixels) {
    findings.peel_pixels = pixels;
    findings.peel_layer = layer_;
  }
  if (scale_.mm2(pixels) > limits_.peel_mm2) extend(peel_, found(IssueKind::kPeelArea, pixels));
  if (layer_ > 0 && pixels > pixels_below_) {
    const std::uint64_t jump = pixels - pixels_below_;
    if (jump > findings.jump_pixels) {
      findings.jump_pixels = jump;
      findings.jump_layer = layer_;
    }
    if (scale_.mm2(jump) > limits_.peel_jump_mm2) add(found(IssueKind::kPeelJump, jump));
  }
  if (pixels > 0) {
    end_gap(findings);
  } else {
    ++empty_layers_;
  }
  if (limits_.travel_mm > 0 && scale_.z_mm(layer_ + 1) > limits_.travel_mm * (1 + kRounding)) {
    extend(height_, found(IssueKind::kPrintHeight, std::max<std::uint64_t>(pixels, 1)));
  }
}

void LayerMeasures::end_gap(StackFindings& findings) {
  if (empty_layers_ == 0) return;
  const std::uint32_t first = layer_ - empty_layers_;
  findings.of(IssueKind::kEmptyLayer).add({IssueKind::kEmptyLayer, first, first, layer_ - 1, 0, 0, 0, 0});
  empty_layers_ = 0;
}

void LayerMeasures::check_bounds(ConstBitImage mask, const RegionBox& box) {
  const std::uint32_t margin = limits_.bound_margin;
  const std::uint32_t inner_column = mask.columns() - std::min(mask.columns(), margin);
  const std::uint32_t inner_row = mask.rows() - std::min(mask.rows(), margin);
  if (!limits_.has_panel || box.empty()) return;
  if (box.column >= margin && box.row >= margin && box.column_end <= inner_column && box.row_end <= inner_row) return;
  Issue issue{IssueKind::kTouchingBound, layer_, layer_, layer_, 0, 0, 0, 0};
  for (std::uint32_t r = box.row; r < box.row_end; ++r) {
    const auto line = mask.row(r);
    const bool whole = r < margin || r >= inner_row;
    const std::uint32_t left_end = whole ? mask.columns() : std::min(margin, mask.columns());
    const std::uint32_t right = whole ? mask.columns() : std::max(inner_column, left_end);
    const std::uint64_t in_left = count_in(line, 0, left_end);
    const std::uint64_t in_row = in_left + count_in(line, right, mask.columns());
    if (in_row > 0 && issue.pixels == 0) {
      issue.row = r;
      issue.column = in_left > 0 ? 0 : right;
      while (!mask.at(issue.column, r)) ++issue.column;
    }
    issue.pixels += in_row;
  }
  issue.voxels = issue.pixels;
  if (issue.pixels > 0) extend(bound_, issue);
}

void LayerMeasures::finish(StackFindings& findings) {
  end_gap(findings);
  for (const Issue* issue : {&bound_, &peel_, &height_}) {
    if (issue->voxels > 0) findings.of(issue->kind).add(*issue);
  }
}

}  // namespace plumbline::inline slicer
