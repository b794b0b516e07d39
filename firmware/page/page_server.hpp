#pragma once
/// The printer's page: what the state socket says, for browsers, and their commands back to it.

#include <array>
#include <chrono>
#include <cstdint>
#include <optional>
#include <string>
#include <string_view>
#include <vector>

#include "firmware/page/http_server.hpp"
#include "firmware/page/page_upload.hpp"
#include "firmware/page/pairing.hpp"
#include "firmware/page/printer_link.hpp"
#include "firmware/settings/board_file.hpp"
#include "firmware/state/client_request.hpp"
#include "firmware/state/state_line.hpp"

namespace plumbline {

class PageServer final : public HttpHandler {
 public:
  using HostClock = std::chrono::steady_clock;

  /// At least this long between two states for one browser.
  static constexpr std::chrono::milliseconds kBetweenEvents{200};
  /// Something is sent at least as often, so that a browser that has gone is noticed.
  static constexpr std::chrono::seconds kSignOfLife{10};
  /// The printer says so much later at most that it has kept a scan: slow storage has to be written.
  static constexpr std::chrono::minutes kKeepPatience{2};
  /// The printer answers when no mask waits: some seconds at most.
  static constexpr std::chrono::seconds kPatience{10};

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
  /// What the printer was asked, and who waits for it.
  struct Question {
    enum class Kind : std::uint8_t { kNone, kCommand, kUpload, kPicture, kMask, kReportBegin, kReportPart };
    Kind kind = Kind::kNone;
    std::uint64_t id = 0;
    HttpTicket ticket{};
    std::size_t stream = 0;
    PictureName picture = PictureName::kPreview;
    std::uint32_t print = 0;  ///< of kReportBegin: 0: the last one
    HostClock::time_point until{};
  };
  struct Picture {
    std::uint32_t number = 0;  ///< 0: none
    std::vector<std::byte> png;
    std::size_t size = 0;
  };
  struct Stream {
    std::uint64_t told = 0;  ///< number of the last event
    HostClock::time_point told_at;
    std::size_t report_bytes = 0;  ///< of report, that wait to be sent
    std::vector<std::byte> report;
  };

  HttpReply get(const HttpRequest& request, const HttpTicket& ticket);
  HttpReply post(const HttpRequest& request, const HttpTicket& ticket);
  std::optional<HttpAnswer> distrust(const HttpRequest& request, std::string_view type);
  HttpReply command(const HttpRequest& request, const HttpTicket& ticket);
  HttpReply upload(const HttpRequest& request, const HttpTicket& ticket);
  HttpReply uploaded(const HttpTicket& ticket);
  void look_at_upload(HttpServer& server, HostClock::time_point now);
  HttpReply pair(const HttpRequest& request);
  HttpReply picture(PictureName name, const HttpTicket& ticket);
  HttpAnswer access(const HttpRequest& request);
  HttpAnswer octoprint(Status (*write)(TextSink&, std::string_view));
  HttpAnswer refuse(unsigned status, const char* error, std::string_view advice = {});

  bool ask(const Question& question, std::string_view line, int file = -1);
  Question* free_question();
  std::optional<std::uint64_t> in_flight(PictureName name) const;

  void receive(HttpServer& server);
  void take_reply(HttpServer& server, std::string_view line);
  void answer_question(HttpServer& server, Question& question, std::string_view line);
  void end_questions(HttpServer& server, HostClock::time_point now, bool all);
  std::size_t write_event(Stream& stream, std::span<char> out);
  std::optional<std::size_t> write_report(std::size_t place, std::uint32_t print, std::uint64_t sent,
                                          std::span<char> out);

  PageChoice page_;
  std::string page_host_;
  Pairing pairing_;
  PrinterLink link_;
  StateLine state_;          ///< the newest; empty: there is no connection
  std::uint64_t event_ = 1;  ///< rises with each state and when the connection ends
  bool owes_event_ = false;  ///< a stream got none yet because it had one a moment ago
  PageUpload upload_;
  HostClock::time_point upload_until_{};  ///< of PageUpload::Stage::kWaiting
  std::array<Question, 24> questions_;
  std::uint64_t last_id_ = 0;
  std::array<Picture, kPictureWords.size()> pictures_;
  std::vector<std::byte> mask_;  ///< scratch
  std::array<Stream, HttpServer::kMostStreams> streams_;
  TextBuffer<4096> text_;  ///< of an answer; copied before the next one
  TextBuffer<16384> faults_;
};

}  // namespace plumbline
