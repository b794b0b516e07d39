#pragma once
/// What the printer was asked, and which browsers wait for its replies.

#include <array>
#include <chrono>
#include <cstdint>
#include <optional>
#include <string_view>

#include "firmware/page/http_server.hpp"
#include "firmware/page/printer_link.hpp"
#include "firmware/state/client_request.hpp"

namespace plumbline::firmware::inline page {

struct PrinterQuestion {
  enum class Kind : std::uint8_t { kNone, kCommand, kUpload, kPicture, kMask, kFileBegin, kFilePart, kAlive };
  Kind kind = Kind::kNone;
  std::uint64_t id = 0;
  HttpTicket ticket{};
  std::size_t stream = 0;
  PictureName picture = PictureName::kPreview;
  std::uint64_t job = 0;    ///< of kPicture, kFileBegin: whose
  std::uint32_t print = 0;  ///< of kFileBegin: 0: the last one
  std::chrono::steady_clock::time_point until{};
};

class PrinterQuestions {
 public:
  using HostClock = std::chrono::steady_clock;

  /// The printer answers when no mask waits: some seconds at most.
  static constexpr std::chrono::seconds kPatience{10};
  static constexpr std::size_t kMost = 24;

  /// @param link  must outlive it
  explicit PrinterQuestions(PrinterLink& link) : link_(link) {}

  std::uint64_t next_id() { return ++last_id_; }
  /// @param line  empty: the printer was asked before
  /// @param file  a descriptor that goes with it; below 0: none
  /// @returns whether an answer can be expected
  bool ask(const PrinterQuestion& question, std::string_view line, int file = -1);
  /// Asks under the next number. @param what  members of the question, as JSON
  bool ask(PrinterQuestion question, const char* what);
  /// The question for a picture of a job whose answer has not come.
  std::optional<std::uint64_t> in_flight(PictureName name, std::uint64_t job) const;
  /// Removes a question that waits for the answer with this number, and returns it. Several may wait for one answer.
  std::optional<PrinterQuestion> take(std::optional<std::uint64_t> id);
  /// The same for one that has waited too long. @param all  or any other
  std::optional<PrinterQuestion> take_late(HostClock::time_point now, bool all);
  /// Whether a question of this kind waits for its answer.
  bool is_asked(PrinterQuestion::Kind kind) const;
  /// Nobody waits for what a stream has asked.
  void forget(std::size_t stream);

 private:
  PrinterLink& link_;
  std::array<PrinterQuestion, kMost> list_;
  std::uint64_t last_id_ = 0;
};

}  // namespace plumbline::firmware::inline page
