#include "firmware/page/printer_questions.hpp"

#include <algorithm>
#include <utility>

#include "firmware/page/printer_texts.hpp"

namespace plumbline::firmware::inline page {

using Kind = PrinterQuestion::Kind;

bool PrinterQuestions::ask(const PrinterQuestion& question, std::string_view line, int file) {
  auto* const free = std::ranges::find(list_, Kind::kNone, &PrinterQuestion::kind);
  if (free == list_.end() || (!line.empty() && !link_.send(line, file))) return false;
  *free = question;
  free->until = HostClock::now() + kPatience;
  return true;
}

bool PrinterQuestions::ask(PrinterQuestion question, const char* what) {
  question.id = next_id();
  return ask(question, question_line(what, question.id).view());
}

std::optional<std::uint64_t> PrinterQuestions::in_flight(PictureName name, std::uint64_t job) const {
  for (const PrinterQuestion& question : list_) {
    if (question.kind == Kind::kPicture && question.picture == name && question.job == job) return question.id;
  }
  return std::nullopt;
}

std::optional<PrinterQuestion> PrinterQuestions::take(std::optional<std::uint64_t> id) {
  for (PrinterQuestion& question : list_) {
    if (question.kind != Kind::kNone && question.id == id) return std::exchange(question, {});
  }
  return std::nullopt;
}

std::optional<PrinterQuestion> PrinterQuestions::take_late(HostClock::time_point now, bool all) {
  for (PrinterQuestion& question : list_) {
    if (question.kind != Kind::kNone && (all || now >= question.until)) return std::exchange(question, {});
  }
  return std::nullopt;
}

bool PrinterQuestions::is_asked(Kind kind) const {
  return std::ranges::find(list_, kind, &PrinterQuestion::kind) != list_.end();
}

void PrinterQuestions::forget(std::size_t stream) {
  for (PrinterQuestion& question : list_) {
    if (question.kind == Kind::kFilePart && question.stream == stream) question = {};
  }
}

}  // namespace plumbline::firmware::inline page
