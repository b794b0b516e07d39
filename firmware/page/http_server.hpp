#pragma once
/// HTTP for the page, by libmicrohttpd, in one thread. Connections, requests and memory are bounded.

#include <array>
#include <chrono>
#include <cstddef>
#include <cstdint>
#include <memory>
#include <optional>
#include <span>
#include <string>
#include <string_view>
#include <variant>

#include "firmware/page/clients/client_address.hpp"
#include "firmware/page/clients/connection_places.hpp"
#include "firmware/state/state_line.hpp"
#include "slicer/core/error.hpp"

namespace plumbline::firmware::inline page {

/// Valid during HttpHandler::answer() only. A header that the request does not have is empty.
struct HttpRequest {
  std::string_view method, path;
  std::string_view host, origin, content_type;
  std::string_view token;                 ///< header Plumbline-Token
  bool takes_gzip = false;                ///< as an answer's encoding
  std::optional<std::uint32_t> n;         ///< ?n=
  std::array<std::uint32_t, 3> window{};  ///< ?x=, ?y=, ?step=; 0: not there
  ClientAddress address;                  ///< whose
  std::string_view job;                   ///< ?job=
  std::string_view body;
};

struct HttpAnswer {
  unsigned status = 200;
  const char* type = "application/json";
  std::string_view body;          ///< copied, unless it is fixed
  bool is_fixed = false;          ///< the body's memory stays as it is for ever
  bool is_gzip = false;           ///< the body is packed: HttpRequest::takes_gzip
  const char* save_as = nullptr;  ///< file name; null: not for saving
  const char* allow = nullptr;    ///< of status 405: the methods
  bool closes = false;            ///< the connection ends with it
};

/// A request that is answered later.
struct HttpTicket {
  std::size_t place = 0;
  std::uint64_t number = 0;
};

/// An answer that is written in parts.
struct HttpStream {
  enum class Kind : std::uint8_t {
    kEvents,  ///< server-sent events, without end
    kParts,   ///< a file of `size` bytes
  };
  /// For what is sent next: an event, or a part of a file.
  static constexpr std::size_t kRoom = kLongestLine + 64;

  Kind kind = Kind::kEvents;
  std::uint64_t size = 0;
  std::uint32_t n = 0;    ///< ?n= of the request that it answers; 0: it had none
  std::uint64_t job = 0;  ///< a file of this job; 0: the report of a print
  const char* type = "text/event-stream";
  const char* save_as = nullptr;
};

struct HttpLater {};
using HttpReply = std::variant<HttpAnswer, HttpLater, HttpStream>;

class HttpHandler {
 public:
  virtual ~HttpHandler() = default;
  /// Whether an address is that of a paired browser: places are kept for those.
  virtual bool is_paired(const ClientAddress& /*address*/) { return false; }
  /// Whether a connection from an address is refused before anything of it is read.
  virtual bool is_flooding(const ClientAddress& /*address*/) { return false; }
  /// Called when a request's headers have come, before its body.
  /// @returns a refusal; none: it is served
  virtual std::optional<HttpAnswer> refuse_early(const HttpRequest& /*request*/) { return std::nullopt; }
  /// Whether the body of a request for this path goes to take_body() as it comes: it may be long, and answer() gets none.
  virtual bool streams_body(std::string_view /*path*/) { return false; }
  /// Called before such a body comes. @param bytes  that were announced; 0: none
  /// @returns a refusal; none: it may come
  virtual std::optional<HttpAnswer> begin_body(const HttpRequest& /*request*/, std::uint64_t /*bytes*/,
                                               const HttpTicket& /*ticket*/) {
    return HttpAnswer{.status = 404, .body = "{}"};
  }
  /// Takes what has come of such a body.
  /// @returns bytes taken; fewer than there are: HttpServer::go_on() comes later; none: the connection ends
  virtual std::optional<std::size_t> take_body(const HttpTicket& /*ticket*/, std::span<const char> /*bytes*/) {
    return std::nullopt;
  }
  /// A request with such a body is over: answered, or its connection has ended.
  virtual void ended(const HttpTicket& /*ticket*/) {}
  /// @returns an answer, or HttpLater: the server waits for HttpServer::finish()
  virtual HttpReply answer(const HttpRequest& request, const HttpTicket& ticket) = 0;
  /// Writes what a stream sends next.
  /// @param stream  below HttpServer::kMostStreams
  /// @param what    as it was begun
  /// @param begins  it is the first part of a new stream
  /// @param sent    bytes that the stream has sent so far
  /// @returns bytes written; 0: nothing yet, HttpServer::wake() or fail() comes later; none: the stream has failed
  virtual std::optional<std::size_t> fill(std::size_t stream, const HttpStream& what, bool begins, std::uint64_t sent,
                                          std::span<char> out) = 0;
};

struct HttpTimes {
  std::chrono::milliseconds request = std::chrono::seconds(15);  ///< for a request to come whole
  std::chrono::milliseconds answer = std::chrono::seconds(60);   ///< for an answer to be taken
};

class HttpServer {
 public:
  using HostClock = std::chrono::steady_clock;

  static constexpr PlaceLimits kPlaces{};
  /// Beside those that are served, for some that are being ended.
  static constexpr unsigned kMostConnections = kPlaces.all + 8;
  static constexpr std::size_t kMostStreams = 10;
  /// Of addresses that are not paired: in all, and of each.
  static constexpr std::size_t kUnpairedStreams = 6, kStreamsOfUnpaired = 4;
  static constexpr std::size_t kLongestBody = 1023;
  /// @param address  numeric; empty: all of this machine
  /// @param port     0: any
  /// @param handler  must outlive the server
  /// @retval ErrorCode::kCannotOpen  the address, the reason
  [[nodiscard]] static Expected<std::unique_ptr<HttpServer>> open(const std::string& address, std::uint16_t port,
                                                                  HttpHandler& handler, const HttpTimes& times = {});
  ~HttpServer();
  HttpServer(const HttpServer&) = delete;
  HttpServer& operator=(const HttpServer&) = delete;

  std::uint16_t port() const;
  /// Becomes readable when run() has something to do.
  int descriptor() const;
  /// The longest that run() may be left uncalled.
  std::chrono::milliseconds patience() const;
  void run();
  /// How many connections got no place since the last call.
  unsigned take_turned_away();

  /// Answers a request. Does nothing if its connection has ended.
  void finish(const HttpTicket& ticket, const HttpAnswer& answer);
  /// take_body() can take more of a request's body. Does nothing if its connection has ended.
  void go_on(const HttpTicket& ticket);
  /// The same as finish() by a stream.
  void begin_stream(const HttpTicket& ticket, const HttpStream& stream);
  /// fill() has something for a stream.
  void wake(std::size_t stream);
  /// A stream can't go on. The browser sees that it did not end well.
  void fail(std::size_t stream);
  /// wake() for all streams of a kind.
  void wake_all(HttpStream::Kind kind);

 private:
  struct Parts;
  explicit HttpServer(std::unique_ptr<Parts> parts);
  std::unique_ptr<Parts> parts_;
};

}  // namespace plumbline::firmware::inline page
