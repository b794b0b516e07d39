#include "firmware/daemon/issue_question.hpp"

#include <string_view>

#include "firmware/io/text/fixed_text.hpp"
#include "firmware/slice/issue_report.hpp"

namespace plumbline {

void IssueQuestion::tell(StateRecorder& recorder) const {
  for_each_issue(findings_, grid_, policy_, [&](IssueKind kind, CheckAction, std::string_view sentence) {
    recorder.warn(sentence, told_issue(kind, findings_, grid_));
  });
}

CheckAction IssueQuestion::action() const { return verdict(findings_, policy_); }

Error IssueQuestion::refusal() const { return judge(findings_, grid_, policy_, false).error(); }

Expected<bool> IssueQuestion::ask(OfferedContract& offered, Answers& answers, StateRecorder& recorder) const {
  const auto say = [&] {
    FixedText<512> text;
    for_each_doubt(offered.contract(), offered.name(), [&text](const Told&, std::string_view sentence) {
      text.add("%.*s. ", static_cast<int>(sentence.size()), sentence.data());
    });
    if (action() == CheckAction::kAsk) {
      text.add("Found in the layers: %s. ", issue_counts(findings_, policy_, CheckAction::kAsk).c_str());
    }
    const bool doubtful = !text.view().empty();
    if (!doubtful) text.add("%s. ", size_line(offered.contract()).c_str());
    text.add("Press start to print it%s, or cancel", doubtful ? " all the same" : "");
    recorder.say(text.view());
  };
  answers.put();
  say();
  offered.changed = say;
  while (!answers.shutdown()) {
    const auto answer = answers.ask();
    PLUMBLINE_TRY(answer);
    if (*answer == EventKind::kStartPressed) return true;
    if (*answer == EventKind::kCancelPressed) break;
  }
  return false;
}

}  // namespace plumbline
