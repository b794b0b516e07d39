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
#include "firmware/page/clients/client_limits.hpp"
#include "firmware/page/clients/paired_browsers.hpp"
#include "firmware/page/clients/pairing_codes.hpp"
#include "firmware/page/http_server.hpp"
#include "firmware/page/page_log.hpp"
#include "firmware/page/page_streams.hpp"
#include "firmware/page/printer_link.hpp"
#include "firmware/page/printer_questions.hpp"
#include "firmware/page/upload_requests.hpp"
#include "firmware/settings/board_file.hpp"
#include "firmware/state/client_request.hpp"
#include "firmware/state/state_line.hpp"

namespace plumbline::firmware::inline page {

class PageServer final : public HttpHandler {
 public:
  using HostClock = std::chrono::steady_clock;

  /// Takes all its memory here.
  /// @param socket     the printer's state socket; commands go to the one beside it
  /// @param page       not PageChoice::kOff
  /// @param page_host  see is_known_host()
  PageServer(const std::string& socket, PageChoice page, std::string page_host, PairedBrowsers browsers);

  bool is_paired(const ClientAddress& address) override;
  bool is_flooding(const ClientAddress& address) override;
  std::optional<HttpAnswer> refuse_early(const HttpRequest& request) override;
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
  HttpAnswer paired_at_once();
  HttpAnswer browsers(const HttpRequest& request);
  HttpAnswer forget(const HttpRequest& request);
  void show_code(HostClock::time_point now);
  HttpReply picture(PictureName name, std::uint64_t job, const HttpTicket& ticket);
  HttpAnswer access(const HttpRequest& request);
  HttpAnswer not_paired();

  void receive_replies(HttpServer& server, PrinterLink& link, PrinterQuestions& questions);
  void answer_question(HttpServer& server, const PrinterQuestion& asked, std::string_view line);
  void lose_printer();
  void look_for_life(HostClock::time_point now);
  void end_questions(HttpServer& server, PrinterLink& link, PrinterQuestions& questions, HostClock::time_point now);

  PageChoice page_;
  std::string page_host_;
  PairedBrowsers browsers_;
  PairingCodes codes_;
  PageCode shown_;         ///< on the printer's screen
  PageToken local_token_;  ///< of all browsers of this machine, if the page is for those alone
  ClientLimits limits_;
  PageLog log_;
  PrinterLink link_;      ///< for looking
  PrinterLink commands_;  ///< of their own: they wait for no picture, and end with it if the printer does not answer
  StateLine state_;       ///< the newest; empty: there is no connection
  HostClock::time_point asked_for_life_{};  ///< when the printer was asked last whether it lives
  bool lives_ = true;                       ///< it has answered, or may still
  AnswerText text_;
  PrinterQuestions questions_{link_};
  PrinterQuestions orders_{commands_};
  UploadRequests uploads_{orders_, text_};
  PageStreams streams_;
  std::array<Picture, kPictureWords.size()> pictures_;
  std::vector<std::byte> mask_;  ///< scratch
};

}  // namespace plumbline::firmware::inline page
