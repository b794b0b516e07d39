#pragma once
/// The printer's page: what the state socket says, for browsers, and their commands back to it.

#include <array>
#include <chrono>
#include <cstdint>
#include <optional>
#include <string>
#include <string_view>
#include <vector>

#include "firmware/page/answer_text.hpp"
#include "firmware/page/http_server.hpp"
#include "firmware/page/page_streams.hpp"
#include "firmware/page/pairing.hpp"
#include "firmware/page/printer_link.hpp"
#include "firmware/page/printer_questions.hpp"
#include "firmware/page/upload_requests.hpp"
#include "firmware/settings/board_file.hpp"
#include "firmware/state/client_request.hpp"
#include "firmware/state/state_line.hpp"

namespace plumbline {

class PageServer final : public HttpHandler {
 public:
  using HostClock = std::chrono::steady_clock;

  /// Takes all its memory here.
  /// @param socket     the printer's state socket; commands go to the one beside it
  /// @param page       not PageChoice::kOff
  /// @param page_host  see is_known_host()
  PageServer(const std::string& socket, PageChoice page, std::string page_host, Pairing pairing);

  HttpReply answer(const HttpRequest& request, const HttpTicket& ticket) override;
  bool streams_body(std::string_view path) override;
  std::optional<HttpAnswer> begin_body(const HttpRequest& request, std::uint64_t bytes,
                                       const HttpTicket& ticket) override;
  std::optional<std::size_t> take_body(const HttpTicket& ticket, std::span<const char> bytes) override;
  void ended(const HttpTicket& ticket) override;
  std::optional<std::size_t> fill(std::size_t stream, const HttpStream& what, bool begins, std::uint64_t sent,
                                  std::span<char> out) override;

  /// Serves until `server` is gone, which is never: a signal ends the process.
  /// @param server  whose handler this is
  [[noreturn]] void run(HttpServer& server);

 private:
  struct Picture {
    std::uint32_t number = 0;  ///< 0: none
    std::vector<std::byte> png;
    std::size_t size = 0;
  };

  HttpReply get(const HttpRequest& request, const HttpTicket& ticket);
  HttpReply post(const HttpRequest& request, const HttpTicket& ticket);
  std::optional<HttpAnswer> distrust(const HttpRequest& request, std::string_view type);
  HttpReply command(const HttpRequest& request, const HttpTicket& ticket);
  HttpReply pair(const HttpRequest& request);
  HttpReply picture(PictureName name, const HttpTicket& ticket);
  HttpAnswer access(const HttpRequest& request);
  HttpAnswer not_paired();

  void receive(HttpServer& server);
  void answer_question(HttpServer& server, const PrinterQuestion& asked, std::string_view line);
  void end_questions(HttpServer& server, HostClock::time_point now, bool all);

  PageChoice page_;
  std::string page_host_;
  Pairing pairing_;
  PrinterLink link_;
  StateLine state_;  ///< the newest; empty: there is no connection
  AnswerText text_;
  PrinterQuestions questions_{link_};
  UploadRequests uploads_{questions_, text_};
  PageStreams streams_;
  std::array<Picture, kPictureWords.size()> pictures_;
  std::vector<std::byte> mask_;  ///< scratch
  TextBuffer<49152> texts_;
};

}  // namespace plumbline
