#include "slicer/checks/slender_parts.hpp"

#include <algorithm>
#include <array>
#include <cmath>

#include "slicer/checks/check_limits.hpp"

namespace plumbline::inline slicer {
namespace {

constexpr double kStep_mm = 0.25;
constexpr double kLargestNeedle_mm2 = 9;  ///< it would be 240 mm high
constexpr double kRounding = 1 - 1e-6;    ///< the layer height is a float

}  // namespace

SlenderParts::SlenderParts(const PrintGrid& grid, std::span<Part> parts)
    : scale_(grid),
      step_(static_cast<std::uint32_t>(std::max(1.0, std::floor(kStep_mm / scale_.layer_height_mm)))),
      parts_(parts) {}

Expected<SlenderParts> SlenderParts::create(const PrintGrid& grid, Arena& arena) {
  const auto parts = arena.take_top<Part>(kMost, "checks");
  PLUMBLINE_TRY(parts);
  return SlenderParts(grid, *parts);
}

bool SlenderParts::find_thin(ConstBitImage mask, const RegionBox& box, BitImage thin) const {
  const auto in_three = [](std::uint64_t before2, std::uint64_t before, std::uint64_t after, std::uint64_t after2) {
    return (before2 & before) | (before & after) | (after & after2);
  };
  std::uint64_t pixels = 0;
  for (std::uint32_t r = box.row; r < box.row_end; ++r) {
    const auto line = mask.row(r);
    const auto row = [&](std::uint32_t at) { return mask.row(at < mask.rows() ? at : r); };
    const std::array rows = {row(r - 2), row(r - 1), row(r + 1), row(r + 2)};
    for (std::uint32_t w = box.column / 64; w < (box.column_end + 63) / 64; ++w) {
      const std::uint64_t here = line[w];
      const std::uint64_t left = w > 0 ? line[w - 1] : 0;
      const std::uint64_t right = w + 1 < line.size() ? line[w + 1] : 0;
      thin.row(r)[w] = here & ~(in_three(here << 2 | left >> 62, here << 1 | left >> 63, here >> 1 | right << 63,
                                         here >> 2 | right << 62) &
                                in_three(rows[0][w], rows[1][w], rows[2][w], rows[3][w]));
      pixels += count_ones(thin.row(r)[w]);
    }
  }
  return static_cast<double>(pixels) * std::max(scale_.pitch_x_mm, scale_.pitch_y_mm) >= CheckLimits::kThinWall_mm;
}

void SlenderParts::add(const Issue& section, const LayerRegions& regions, std::uint32_t region) {
  const bool is_needle = section.kind == IssueKind::kNeedle;
  if (is_needle && scale_.mm2(section.pixels) > kLargestNeedle_mm2) return;
  RegionBox box;
  regions.any_run_of(region, [&](std::uint32_t row, std::uint32_t i) {
    const LayerRegions::Run& run = regions.run(i);
    box = joined(box, {run.first, run.last + 1U, row, row + 1});
    return false;
  });
  const double wide =
      std::max((box.column_end - box.column) * scale_.pitch_x_mm, (box.row_end - box.row) * scale_.pitch_y_mm);
  if (is_needle ? wide > 2 * scale_.width_mm(section) : wide < CheckLimits::kThinWall_mm * kRounding) return;
  Part* const end = parts_.data() + count_;
  Part* const part = std::find_if(parts_.data(), end, [&](const Part& known) {
    const RegionBox& other = known.box;
    return known.issue.kind == section.kind && box.column <= other.column_end && other.column <= box.column_end &&
           box.row <= other.row_end && other.row <= box.row_end &&
           (!is_needle || 4 * section.pixels > known.issue.pixels);
  });
  if (part == end) {
    if (count_ < kMost) parts_[count_++] = {box, section};
    return;
  }
  part->box = part->issue.last_layer == section.layer ? joined(part->box, box) : box;
  part->issue.last_layer = section.layer;
  part->issue.pixels = section.pixels;
  part->issue.voxels += section.pixels;
}

void SlenderParts::end_look(std::uint32_t layer, StackFindings& findings) {
  std::size_t kept = 0;
  for (Part& part : parts_.first(count_)) {
    Issue& issue = part.issue;
    if (issue.last_layer == layer) {
      parts_[kept++] = part;
      continue;
    }
    issue.pixels = issue.voxels /= (issue.last_layer - issue.first_layer) / step_ + 1;
    issue.last_layer = std::min(issue.last_layer + step_, findings.layers) - 1;
    const bool told = issue.kind == IssueKind::kNeedle
                          ? scale_.slenderness(issue) >= CheckLimits::kNeedleRatio * kRounding
                          : scale_.z_mm(issue.layers()) >= CheckLimits::kThinWall_mm * kRounding;
    if (told) findings.of(issue.kind).add(issue);
  }
  count_ = kept;
}

}  // namespace plumbline::inline slicer
