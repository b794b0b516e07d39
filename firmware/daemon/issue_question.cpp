#include "firmware/daemon/issue_question.hpp"

#include <string_view>

#include "firmware/daemon/sliced_record.hpp"
#include "firmware/io/text/fixed_text.hpp"
#include "firmware/slice/issue_report.hpp"

namespace plumbline {

void IssueQuestion::tell(StateRecorder& recorder) const {
  for_each_issue(findings_, grid_, policy_, [&](IssueKind kind, CheckAction, std::string_view sentence) {
    recorder.warn(sentence, told_issue(kind, findings_, grid_));
  });
}

CheckAction IssueQuestion::action() const { return verdict(findings_, policy_); }

Error IssueQuestion::refusal() const { return judge(findings_, grid_, policy_).error(); }

Expected<bool> IssueQuestion::ask(const SlicedRecord& sliced, Answers& answers, StateRecorder& recorder) const {
  FixedText<400> text;
  if (action() == CheckAction::kAsk) {
    text.add("found in the layers: %s. Press start to print it all the same, or cancel",
             issue_counts(findings_, policy_, CheckAction::kAsk).c_str());
  } else {
    text.add("%s. Press start to print it, or cancel", sliced_line(sliced).c_str());
  }
  recorder.say(text.view());
  while (!answers.shutdown()) {
    const auto answer = answers.ask();
    PLUMBLINE_TRY(answer);
    if (*answer == EventKind::kStartPressed) return true;
    if (*answer == EventKind::kCancelPressed) break;
  }
  return false;
}

}  // namespace plumbline
