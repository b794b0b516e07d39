#include "firmware/setup/dialogue.hpp"

#include <poll.h>
#include <unistd.h>

#include <algorithm>
#include <array>
#include <cerrno>

#include "firmware/io/interrupt.hpp"
#include "firmware/io/progress_lines.hpp"

namespace plumbline::firmware {
namespace {

/// Far above any answer; a pasted file must not fill the memory.
constexpr std::size_t kLongestAnswer = 1000;
constexpr int kWatchMs = 100;

std::string_view trimmed(std::string_view text) {
  constexpr std::string_view kSpaces = " \t\r\n";
  const std::size_t begin = text.find_first_not_of(kSpaces);
  if (begin == std::string_view::npos) return {};
  return text.substr(begin, text.find_last_not_of(kSpaces) - begin + 1);
}

void write_text(std::string_view text) {
  while (!text.empty()) {
    const auto written = ::write(STDERR_FILENO, text.data(), text.size());
    if (written <= 0 && errno != EINTR) return;
    if (written > 0) text.remove_prefix(static_cast<std::size_t>(written));
  }
}

}  // namespace

Status Dialogue::ask(const Question& question, const std::function<Status(const std::string&)>& take) {
  for (;;) {
    auto given = answer(question);
    PLUMBLINE_TRY(given);
    if (given->empty()) *given = question.fallback;
    const Status taken = given->empty() ? Status(fail(ErrorCode::kBadSetting, "this needs an answer")) : take(*given);
    if (taken || taken.error().code() == ErrorCode::kCancelled) return taken;
    PLUMBLINE_TRY(refuse(question, taken.error()));
  }
}

Expected<bool> Dialogue::ask_yes(Question question) {
  question.allowed = "yes or no";
  bool yes = false;
  PLUMBLINE_TRY(ask(question, [&](const std::string& text) -> Status {
    yes = text == "yes" || text == "y";
    if (yes || text == "no" || text == "n") return {};
    return fail(ErrorCode::kBadSetting, "answer yes or no");
  }));
  return yes;
}

void TerminalDialogue::say(std::string_view text) { write_text(std::string(text) + "\n"); }

Expected<std::string> TerminalDialogue::answer(const Question& question) {
  std::string text = "\n" + question.name + ": " + question.text + "\n";
  if (!question.allowed.empty()) text += "  " + question.allowed + "\n";
  text += question.fallback.empty() ? "  > " : "  [" + question.fallback + "] > ";
  write_text(text);
  for (;;) {
    if (const std::size_t end = unread_.find('\n'); end != std::string::npos) {
      const std::string line(trimmed(std::string_view(unread_).substr(0, end)));
      unread_.erase(0, end + 1);
      return line;
    }
    if (unread_.size() > kLongestAnswer) {
      unread_.clear();
      return fail(ErrorCode::kCancelled, "an answer of more than %zu characters: nothing was written", kLongestAnswer);
    }
    if (interrupted()) return fail(ErrorCode::kCancelled, "interrupted: nothing was written");
    if (watch) PLUMBLINE_TRY(watch());
    pollfd input{.fd = STDIN_FILENO, .events = POLLIN, .revents = 0};
    if (::poll(&input, 1, kWatchMs) <= 0) continue;
    std::array<char, 256> bytes{};
    const auto count = ::read(STDIN_FILENO, bytes.data(), bytes.size());
    if (count == 0) return fail(ErrorCode::kCancelled, "the input has ended: nothing was written");
    if (count > 0) unread_.append(bytes.data(), static_cast<std::size_t>(count));
    if (count < 0 && errno != EINTR && errno != EAGAIN) {
      return fail(ErrorCode::kCancelled, "the input can't be read: nothing was written");
    }
  }
}

Status TerminalDialogue::refuse(const Question& /*question*/, const Error& reason) {
  write_text(std::string("  ") + reason.message() + "\n");
  return {};
}

Expected<std::unique_ptr<WrittenAnswers>> WrittenAnswers::parse(std::string_view text, std::string path) {
  std::unique_ptr<WrittenAnswers> answers(new WrittenAnswers(std::move(path)));
  const std::string shown(PrintableText(answers->path_, 150).view());
  for (std::size_t number = 1; !text.empty(); ++number) {
    const std::size_t end = std::min(text.find('\n'), text.size() - 1) + 1;
    const std::string_view line = trimmed(text.substr(0, end));
    text.remove_prefix(end);
    if (line.empty() || line.starts_with('#')) continue;
    const std::size_t equals = line.find('=');
    const std::string_view name = trimmed(line.substr(0, equals));
    if (equals == std::string_view::npos || name.empty()) {
      return fail(ErrorCode::kMalformed, "%s:%zu: expected a line such as panel.columns = 1440", shown.c_str(), number);
    }
    const std::string answer(trimmed(line.substr(equals + 1)));
    if (answer.size() > kLongestAnswer || !answers->answers_.emplace(name, Answer{answer, number, false}).second) {
      return fail(ErrorCode::kMalformed, "%s:%zu: %s is answered twice, or too long", shown.c_str(), number,
                  PrintableText(name, 60).c_str());
    }
  }
  return answers;
}

void WrittenAnswers::say(std::string_view text) {
  while (!text.empty()) {
    const std::size_t end = std::min(text.find('\n'), text.size());
    write_line(text.substr(0, end));
    text.remove_prefix(std::min(end + 1, text.size()));
  }
}

Status WrittenAnswers::check_all_used() const {
  for (const auto& [name, answer] : answers_) {
    if (answer.used) continue;
    return fail(ErrorCode::kBadSetting, "%s:%zu: nobody asked %s. Correct its name, or remove the line",
                PrintableText(path_, 150).c_str(), answer.line, PrintableText(name, 60).c_str());
  }
  return {};
}

Expected<std::string> WrittenAnswers::answer(const Question& question) {
  if (interrupted()) return fail(ErrorCode::kCancelled, "interrupted: nothing was written");
  if (watch) PLUMBLINE_TRY(watch());
  const auto found = answers_.find(question.name);
  if (found == answers_.end()) {
    if (!question.fallback.empty()) return question.fallback;
    return fail(ErrorCode::kBadSetting, "%s: no answer to %s: %s.%s%s", PrintableText(path_, 150).c_str(),
                question.name.c_str(), question.text.c_str(), question.allowed.empty() ? "" : " Allowed is ",
                question.allowed.c_str());
  }
  found->second.used = true;
  return found->second.text;
}

Status WrittenAnswers::refuse(const Question& question, const Error& reason) {
  const auto given = answers_.find(question.name);
  if (given == answers_.end()) {
    return fail(ErrorCode::kBadSetting, "%s: add an answer to %s: %s", PrintableText(path_, 150).c_str(),
                question.name.c_str(), reason.message());
  }
  return fail(ErrorCode::kBadSetting, "%s:%zu: %s: %s", PrintableText(path_, 150).c_str(), given->second.line,
              question.name.c_str(), reason.message());
}

}  // namespace plumbline::firmware
