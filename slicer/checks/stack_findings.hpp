#pragma once
/// The findings of one sweep over a stack of masks.

#include <algorithm>
#include <array>
#include <cmath>
#include <cstdint>
#include <span>

#include "slicer/checks/issue.hpp"
#include "slicer/core/print_grid.hpp"

namespace plumbline::inline slicer {

/// All issues of a kind are counted, the largest are kept.
struct IssueGroup {
  static constexpr std::size_t kKept = 8;

  std::uint32_t count = 0;
  std::uint32_t minor = 0;   ///< of them, those that only the manifest has: find_what_matters()
  std::uint64_t pixels = 0;  ///< sum of Issue::pixels
  std::uint64_t voxels = 0;  ///< sum of Issue::voxels
  std::uint32_t kept_count = 0;
  std::array<Issue, kKept> kept;  ///< largest first; of equal ones the lower, then the earlier found

  std::uint32_t told() const { return count - minor; }
  std::span<const Issue> all_kept() const { return std::span(kept).first(kept_count); }
  /// Those that a person is told of come first.
  std::span<const Issue> told_kept() const { return all_kept().first(std::min(kept_count, told())); }

  void add(const Issue& issue) {
    ++count;
    pixels += issue.pixels;
    voxels += issue.voxels;
    const auto larger = [](const Issue& a, const Issue& b) {
      return a.size() != b.size() ? a.size() > b.size() : a.first_layer < b.first_layer;
    };
    std::size_t at = kept_count;
    while (at > 0 && larger(issue, kept[at - 1])) --at;
    if (at == kKept) return;
    kept_count = std::min<std::uint32_t>(kept_count + 1, kKept);
    for (std::size_t i = kept_count - 1; i > at; --i) kept[i] = kept[i - 1];
    kept[at] = issue;
  }
  bool operator==(const IssueGroup&) const = default;
};

/// Plain numbers, so that a process can hand them to another.
struct StackFindings {
  std::array<IssueGroup, kIssueKindCount> groups;  ///< by IssueKind
  std::uint32_t layers = 0;                        ///< of the stack
  std::uint32_t unchecked_layers = 0;              ///< too fine for the memory: their regions were not looked at
  std::uint64_t voxels = 0;                        ///< white ones
  std::uint64_t shadowed_voxels =
      0;  ///< of what is held, those that get no light, since something has fallen below them
  std::uint64_t first_layer_pixels = 0;
  std::uint64_t peel_pixels = 0;  ///< of the largest layer
  std::uint32_t peel_layer = 0;
  std::uint64_t jump_pixels = 0;  ///< largest growth from one layer to the next
  std::uint32_t jump_layer = 0;

  IssueGroup& of(IssueKind kind) { return groups[static_cast<std::size_t>(kind)]; }
  const IssueGroup& of(IssueKind kind) const { return groups[static_cast<std::size_t>(kind)]; }
  std::uint32_t count(IssueKind kind) const { return of(kind).count; }
  bool any() const {  ///< that a person is told of
    return unchecked_layers > 0 ||
           std::any_of(groups.begin(), groups.end(), [](const IssueGroup& group) { return group.told() > 0; });
  }

  /// Share of the stack that falls off while it is printed, 0 to 1.
  double fallen_share() const {
    return voxels > 0 ? static_cast<double>(of(IssueKind::kFreePiece).voxels) / static_cast<double>(voxels) : 0;
  }
  bool operator==(const StackFindings&) const = default;
};

/// Sizes in the units of reports.
struct IssueScale {
  double pixel_mm2 = 0;
  double voxel_ml = 0;
  double pitch_x_mm = 0, pitch_y_mm = 0, layer_height_mm = 0;

  explicit IssueScale(const PrintGrid& grid)
      : pitch_x_mm(static_cast<double>(grid.pitch_x_mm)),
        pitch_y_mm(static_cast<double>(grid.pitch_y_mm)),
        layer_height_mm(static_cast<double>(grid.layer_height_mm)) {
    pixel_mm2 = pitch_x_mm * pitch_y_mm;
    voxel_ml = pixel_mm2 * layer_height_mm / 1000;
  }
  double mm2(std::uint64_t pixels) const { return static_cast<double>(pixels) * pixel_mm2; }
  double ml(std::uint64_t voxels) const { return static_cast<double>(voxels) * voxel_ml; }
  double x_mm(const Issue& issue) const { return (issue.column + 0.5) * pitch_x_mm; }
  double y_mm(const Issue& issue) const { return (issue.row + 0.5) * pitch_y_mm; }
  double z_mm(std::uint32_t layer) const { return layer * layer_height_mm; }  ///< its underside
  /// Side of a square of an issue's area; a needle's height over it.
  double width_mm(const Issue& issue) const { return std::sqrt(mm2(issue.pixels)); }
  double slenderness(const Issue& issue) const { return z_mm(issue.layers()) / width_mm(issue); }
};

}  // namespace plumbline::inline slicer
