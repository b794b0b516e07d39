#include "slicer/checks/what_matters.hpp"

#include <algorithm>
#include <span>

namespace plumbline::inline slicer {
namespace {

bool is_small(const Issue& issue, const IssueScale& scale) {
  const double mm3 = 1000 * scale.ml(issue.voxels);
  switch (issue.kind) {
    case IssueKind::kFreePiece:
    case IssueKind::kTear: return mm3 < MatteringFloors::kPiece_mm3;
    case IssueKind::kResinTrap: return mm3 < MatteringFloors::kTrap_mm3;
    case IssueKind::kSuctionCup: return mm3 < MatteringFloors::kCup_mm3;
    case IssueKind::kPlateTrap: return mm3 < MatteringFloors::kPlateTrap_mm3;
    case IssueKind::kUnreached: return scale.mm2(issue.pixels) < MatteringFloors::kSag_mm2;
    default: return false;
  }
}

/// Whether an issue's place is in a strut.
bool is_in_strut(const Issue& issue, const IssueScale& scale, std::span<const Strut> struts) {
  return std::ranges::any_of(struts, [&](const Strut& strut) {
    if (!strut.is_in(issue.layer)) return false;
    const StrutSection disc = section_of(strut, issue.layer);
    const double dx = (static_cast<double>(issue.column) - disc.column) * scale.pitch_x_mm;
    const double dy = (static_cast<double>(issue.row) - disc.row) * scale.pitch_y_mm;
    const double radius = static_cast<double>(disc.radius) / 1e6;
    return dx * dx + dy * dy <= radius * radius;
  });
}

/// Whether only what plumbline has added causes it.
bool is_of_supports(const Issue& issue, const IssueScale& scale, const AddedSupports& added) {
  switch (issue.kind) {
    case IssueKind::kTouchingBound: return added.drawn && added.object_clear;
    // It rests on tips, or no support reaches it. If that is too little, something falls or tears off.
    case IssueKind::kIsland: return added.drawn;
    case IssueKind::kResinTrap:
    case IssueKind::kSuctionCup:
    case IssueKind::kPlateTrap:
    case IssueKind::kFirstLayerArea:
    case IssueKind::kPeelArea:
    case IssueKind::kPeelJump: return issue.last_layer < added.raft_layers;
    case IssueKind::kNeedle:
    case IssueKind::kThinWall: return is_in_strut(issue, scale, added.struts);
    // Supports cause none of these; what falls or tears off does harm even if it is a support.
    case IssueKind::kOverhang:
    case IssueKind::kFreePiece:
    case IssueKind::kTear:
    case IssueKind::kEmptyLayer:
    case IssueKind::kPrintHeight:
    case IssueKind::kUnreached:
    case IssueKind::kUnreachedIsland: break;
  }
  return false;
}

}  // namespace

void find_what_matters(StackFindings& findings, const PrintGrid& grid, const AddedSupports& added) {
  const IssueScale scale(grid);
  for (std::size_t i = 0; i < kIssueKindCount; ++i) {
    IssueGroup& group = findings.groups[i];
    const auto kept = std::span(group.kept).first(group.kept_count);
    // Those that are not kept are no larger than the last one.
    const bool rest_is_minor = !kept.empty() && is_small(kept.back(), scale);
    // As std::stable_partition(), which asks the heap for room.
    auto minor = kept.begin();
    for (auto issue = kept.begin(); issue != kept.end(); ++issue) {
      if (!is_small(*issue, scale) && !is_of_supports(*issue, scale, added)) std::rotate(minor++, issue, issue + 1);
    }
    const auto kept_minor = static_cast<std::uint32_t>(kept.end() - minor);
    const bool none_matters = rest_is_minor || minor == kept.begin();
    group.minor = kept_minor + (none_matters ? group.count - group.kept_count : 0);
  }
  const bool any_lost = findings.of(IssueKind::kFreePiece).told() > 0 || findings.of(IssueKind::kTear).told() > 0;
  if (IssueGroup& islands = findings.of(IssueKind::kUnreachedIsland); !any_lost) islands.minor = islands.count;
}

}  // namespace plumbline::inline slicer
