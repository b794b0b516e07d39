#pragma once
/// The findings of the checks in words and as JSON, and what follows from them.

#include <optional>
#include <string_view>

#include "firmware/io/text/fixed_text.hpp"
#include "firmware/io/text/json_writer.hpp"
#include "firmware/settings/check_policy.hpp"
#include "slicer/checks/check_limits.hpp"
#include "slicer/checks/stack_findings.hpp"
#include "slicer/core/error.hpp"
#include "slicer/core/function_ref.hpp"
#include "slicer/placement/placement.hpp"
#include "slicer/supports/support_settings.hpp"

namespace plumbline::firmware {

/// The limits for a job. With a printer its panel has an edge and its Z stage a travel.
CheckLimits check_limits(const PlacementSettings& placement, const PeelSettings& peel, double overcure_mm,
                         OverhangRule overhangs = OverhangRule::kEroded);
/// The overhang rule for masks of our own. With supports, overhangs are held or told as not reached.
inline OverhangRule rule_for(const std::optional<SupportSettings>& supports) {
  return supports ? OverhangRule::kNone : OverhangRule::kNeedSupport;
}

/// The limits for coarse masks, whose pixels are larger than those that the defaults are meant for.
CheckLimits coarse_limits(const PrintGrid& grid, const PeelSettings& peel);

/// "3 islands, the largest of 1.46 mm2 (582 px) at x 34.2, y 61.0 mm in layer 702 (35.10 mm)".
/// @param group  not empty
Sentence issue_sentence(IssueKind kind, const StackFindings& findings, const PrintGrid& grid);

/// The same as a code with values.
Told told_issue(IssueKind kind, const StackFindings& findings, const PrintGrid& grid);

/// "2 islands, 1 resin trap", "no issues".
Sentence issue_counts(const StackFindings& findings);
/// Only the kinds for which `policy` has `action`; empty: there are none.
Sentence issue_counts(const StackFindings& findings, const CheckPolicy& policy, CheckAction action);

using IssueVisit = FunctionRef<void(IssueKind kind, CheckAction action, std::string_view sentence)>;
/// Calls visit() for each kind that was found and is not ignored: the sentence, a colon and the advice.
void for_each_issue(const StackFindings& findings, const PrintGrid& grid, const CheckPolicy& policy, IssueVisit visit);

/// The strictest action for what was found.
CheckAction verdict(const StackFindings& findings, const CheckPolicy& policy);

/// @param at_terminal  whether the message may name options of the command line
/// @retval ErrorCode::kBadSetting  something must not be printed, or must be accepted first; the message says what was found: the first of the
///                                 strictest kinds with size and place, and how many of the others
[[nodiscard]] Status judge(const StackFindings& findings, const PrintGrid& grid, const CheckPolicy& policy,
                           bool at_terminal = true);

/// Writes the findings as the member "issues"; null if there are none. firmware/README.md explains it.
void write_issues(JsonWriter& json, const std::optional<StackFindings>& findings, const PrintGrid& grid,
                  const CheckPolicy& policy);

}  // namespace plumbline::firmware
