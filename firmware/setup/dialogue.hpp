#pragma once
/// Questions to whoever sets up a printer, and their answers: from a terminal or from a file.

#include <functional>
#include <map>
#include <memory>
#include <string>
#include <string_view>

#include "slicer/core/error.hpp"

namespace plumbline::firmware {

struct Question {
  std::string name;      ///< "panel.columns", as an answers file has it
  std::string text;      ///< what it is for
  std::string allowed;   ///< "an integer from 1 to 16384 pixels"; empty: the text says it
  std::string fallback;  ///< the answer if the person just presses return; empty: there is none
};

class Dialogue {
 public:
  Dialogue() = default;
  Dialogue(const Dialogue&) = delete;
  Dialogue& operator=(const Dialogue&) = delete;
  virtual ~Dialogue() = default;

  virtual void say(std::string_view text) = 0;

  /// Asks until `take` accepts the answer.
  /// @param take  Status(const std::string& answer): its error is what the person reads
  /// @retval ErrorCode::kCancelled   Ctrl-C, SIGTERM, the end of the input, or what the watch returned
  /// @retval ErrorCode::kBadSetting  an answers file has none, or a wrong one: its name and line
  [[nodiscard]] Status ask(const Question& question, const std::function<Status(const std::string&)>& take);
  /// A question with the answers yes and no.
  [[nodiscard]] Expected<bool> ask_yes(Question question);

  /// Called several times a second while a person thinks. An error ends the question.
  std::function<Status()> watch;

 private:
  /// @returns the answer without spaces around it
  virtual Expected<std::string> answer(const Question& question) = 0;
  /// Tells why the answer does not do. An error where nobody can answer again.
  virtual Status refuse(const Question& question, const Error& reason) = 0;
};

/// A person at standard input and standard error.
class TerminalDialogue final : public Dialogue {
 public:
  void say(std::string_view text) override;

 private:
  Expected<std::string> answer(const Question& question) override;
  Status refuse(const Question& question, const Error& reason) override;

  std::string unread_;
};

/// A file with a line `name = answer` for each question. A question without a line gets its fallback.
class WrittenAnswers final : public Dialogue {
 public:
  /// @param path  for messages
  /// @retval ErrorCode::kMalformed  a line that is none, or a name twice: file and line
  [[nodiscard]] static Expected<std::unique_ptr<WrittenAnswers>> parse(std::string_view text, std::string path);

  void say(std::string_view text) override;
  /// @retval ErrorCode::kBadSetting  an answer to a question that was not asked, such as a misspelt name
  [[nodiscard]] Status check_all_used() const;

 private:
  struct Answer {
    std::string text;
    std::size_t line = 0;
    bool used = false;
  };
  explicit WrittenAnswers(std::string path) : path_(std::move(path)) {}
  Expected<std::string> answer(const Question& question) override;
  Status refuse(const Question& question, const Error& reason) override;

  std::string path_;
  std::map<std::string, Answer, std::less<>> answers_;
};

}  // namespace plumbline::firmware
