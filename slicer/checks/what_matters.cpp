#include "slicer/checks/what_matters.hpp"

#include <algorithm>
#include <span>

namespace plumbline::inline slicer {
namespace {

/// ml; 0: all of the kind matter.
double floor_ml(IssueKind kind) {
  switch (kind) {
    case IssueKind::kFreePiece:
    case IssueKind::kTear: return MatteringFloors::kPiece_mm3 / 1000;
    case IssueKind::kResinTrap: return MatteringFloors::kTrap_mm3 / 1000;
    case IssueKind::kSuctionCup: return MatteringFloors::kCup_mm3 / 1000;
    default: return 0;
  }
}

/// Whether only what plumbline has added causes it.
bool is_of_supports(const Issue& issue, const AddedSupports& added) {
  switch (issue.kind) {
    case IssueKind::kOverhang: return added.drawn;
    case IssueKind::kTouchingBound: return added.drawn && added.object_clear;
    case IssueKind::kIsland:
    case IssueKind::kResinTrap:
    case IssueKind::kSuctionCup:
    case IssueKind::kFirstLayerArea:
    case IssueKind::kPeelArea:
    case IssueKind::kPeelJump: return issue.last_layer < added.raft_layers;
    // What falls or tears off does harm whatever it is, and gaps and heights are the print's.
    case IssueKind::kFreePiece:
    case IssueKind::kTear:
    case IssueKind::kEmptyLayer:
    case IssueKind::kPrintHeight: break;
  }
  return false;
}

}  // namespace

void find_what_matters(StackFindings& findings, const PrintGrid& grid, const AddedSupports& added) {
  const IssueScale scale(grid);
  for (std::size_t i = 0; i < kIssueKindCount; ++i) {
    IssueGroup& group = findings.groups[i];
    const double floor = floor_ml(static_cast<IssueKind>(i));
    const auto is_small = [&](const Issue& issue) { return floor > 0 && scale.ml(issue.voxels) < floor; };
    const auto kept = std::span(group.kept).first(group.kept_count);
    const bool all_of_supports = static_cast<IssueKind>(i) == IssueKind::kOverhang && added.drawn;
    // Those that are not kept are no larger than the last one.
    const bool rest_is_minor = all_of_supports || (!kept.empty() && is_small(kept.back()));
    // As std::stable_partition(), which asks the heap for room.
    auto minor = kept.begin();
    for (auto issue = kept.begin(); issue != kept.end(); ++issue) {
      if (!is_small(*issue) && !is_of_supports(*issue, added)) std::rotate(minor++, issue, issue + 1);
    }
    const auto kept_minor = static_cast<std::uint32_t>(kept.end() - minor);
    const bool none_matters = rest_is_minor || minor == kept.begin();
    group.minor = kept_minor + (none_matters ? group.count - group.kept_count : 0);
  }
}

}  // namespace plumbline::inline slicer
