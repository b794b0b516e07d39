#pragma once

#include "firmware/daemon/answers.hpp"
#include "firmware/daemon/offered_contract.hpp"
#include "firmware/daemon/state_recorder.hpp"
#include "firmware/settings/check_policy.hpp"
#include "slicer/checks/stack_findings.hpp"
#include "slicer/core/error.hpp"

namespace plumbline {

/// Whether to print masks in which the checks have found something.
class IssueQuestion {
 public:
  /// All must outlive the question.
  IssueQuestion(const StackFindings& findings, const PrintGrid& grid, const CheckPolicy& policy)
      : findings_(findings), grid_(grid), policy_(policy) {}

  /// Says what was found.
  void tell(StateRecorder& recorder) const;
  /// What the policy has for the worst of it.
  CheckAction action() const;
  /// @pre action() is CheckAction::kRefuse
  Error refusal() const;
  /// Asks a person whether to print it, with what was found and what is doubtful.
  /// @param offered  may change meanwhile
  /// @returns false: it was declined, or the system shuts down
  [[nodiscard]] Expected<bool> ask(OfferedContract& offered, Answers& answers, StateRecorder& recorder) const;

 private:
  const StackFindings& findings_;
  const PrintGrid& grid_;
  const CheckPolicy& policy_;
};

}  // namespace plumbline
