#pragma once
/// What happens when the checks of the masks find something: the [checks] of a profile, and what the command line changes.

#include <array>
#include <cstdint>
#include <optional>
#include <string_view>

#include "slicer/checks/issue.hpp"

namespace plumbline::firmware::inline settings {

enum class CheckAction : std::uint8_t {
  kIgnore,  ///< it is in the manifest only
  kWarn,    ///< it is said
  kAsk,     ///< the printer waits until somebody presses start again; on the command line it takes --accept
  kRefuse,  ///< nothing is printed
};
inline constexpr std::array<std::string_view, 4> kCheckActionWords = {"ignore", "warn", "ask", "refuse"};

struct CheckPolicy {
  std::array<CheckAction, kIssueKindCount> actions;  ///< by IssueKind

  CheckPolicy() {
    actions.fill(CheckAction::kWarn);
    of(IssueKind::kPrintHeight) = CheckAction::kRefuse;
    of(IssueKind::kUnreachedIsland) = CheckAction::kAsk;
  }
  CheckAction& of(IssueKind kind) { return actions[static_cast<std::size_t>(kind)]; }
  CheckAction of(IssueKind kind) const { return actions[static_cast<std::size_t>(kind)]; }
};

/// A job's changes to the policy.
struct CheckChoice {
  std::array<std::optional<CheckAction>, kIssueKindCount> actions;  ///< by IssueKind; none: as in the profile
  bool accept = false;                                              ///< what the profile asks about is accepted

  CheckPolicy over(CheckPolicy policy) const {
    for (std::size_t i = 0; i < kIssueKindCount; ++i) {
      if (actions[i]) policy.actions[i] = *actions[i];
      if (accept && policy.actions[i] == CheckAction::kAsk) policy.actions[i] = CheckAction::kWarn;
    }
    return policy;
  }
};

}  // namespace plumbline::firmware::inline settings
