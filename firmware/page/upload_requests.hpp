#pragma once
/// The two requests by which a browser uploads a scan. First it asks whether the printer takes it, then it sends it as a body: a browser
/// that is refused while it sends a long body may not see why.

#include <chrono>
#include <cstdint>
#include <optional>
#include <span>
#include <string_view>

#include "firmware/page/answer_text.hpp"
#include "firmware/page/http_server.hpp"
#include "firmware/page/page_upload.hpp"
#include "firmware/page/printer_questions.hpp"

namespace plumbline::firmware::inline page {

class UploadRequests {
 public:
  using HostClock = std::chrono::steady_clock;

  /// The printer says so much later at most that it has kept a scan: slow storage has to be written.
  static constexpr std::chrono::minutes kKeepPatience{2};

  /// Both must outlive it.
  UploadRequests(PrinterQuestions& questions, AnswerText& text) : questions_(questions), text_(text) {}

  /// Asks the printer whether it takes a scan.
  HttpReply ask(std::string_view body, const HttpTicket& ticket);
  /// The printer has answered, or not in time. @param reply  empty: it does not take the scan
  void answered(std::string_view reply);

  /// @returns a refusal; none: the body may come
  std::optional<HttpAnswer> begin_body(std::uint32_t number, std::uint64_t bytes, const HttpTicket& ticket);
  /// As HttpHandler::take_body() and ended().
  std::optional<std::size_t> take_body(const HttpTicket& ticket, std::span<const char> bytes);
  void ended(const HttpTicket& ticket);
  /// All of the body has come: the printer says whether the scan is kept.
  HttpReply whole(const HttpTicket& ticket);

  /// There is a new state.
  void look_at(std::string_view state) { upload_.look_at(state); }
  /// Tells the browser what became of its upload, once that is known.
  /// @param is_there  whether the printer is
  void serve(HttpServer& server, HostClock::time_point now, bool is_there);

  /// Becomes writable when the printer takes more; -1: nothing waits for that.
  int awaited() const { return upload_.wants_room() ? upload_.descriptor() : -1; }
  void has_room(HttpServer& server);

 private:
  PrinterQuestions& questions_;
  AnswerText& text_;
  PageUpload upload_;
  HostClock::time_point until_{};  ///< of PageUpload::Stage::kWaiting
};

}  // namespace plumbline::firmware::inline page
