#include "firmware/page/http_server.hpp"

#include <microhttpd.h>
#include <netinet/in.h>
#include <sys/socket.h>
#include <unistd.h>

#include <algorithm>
#include <cstring>
#include <utility>

#include "firmware/io/descriptor.hpp"
#include "firmware/page/listening_socket.hpp"
#include "slicer/core/numbers/to_number.hpp"

namespace plumbline::firmware::inline page {
namespace {

/// Of each connection, for the request's line and headers and the answer's: a longer request is refused by libmicrohttpd.
constexpr std::size_t kConnectionMemory = std::size_t{16} * 1024;
constexpr unsigned kIdleSeconds = 20;

constexpr const char* kPolicy =
    "default-src 'none'; script-src 'self'; style-src 'self'; img-src 'self' data:; connect-src 'self'; "
    "frame-ancestors 'none'; base-uri 'none'; form-action 'none'";

struct ResponseEnd {
  void operator()(MHD_Response* response) const { MHD_destroy_response(response); }
};
using Response = std::unique_ptr<MHD_Response, ResponseEnd>;

void add(const Response& response, const char* name, const char* value) {
  static_cast<void>(MHD_add_response_header(response.get(), name, value));
}

void add_headers(const Response& response, const char* type, const char* save_as) {
  add(response, "Content-Type", type);
  add(response, "Cache-Control", "no-store");
  add(response, "Content-Security-Policy", kPolicy);
  add(response, "Cross-Origin-Resource-Policy", "same-origin");
  add(response, "Referrer-Policy", "no-referrer");
  add(response, "X-Content-Type-Options", "nosniff");
  if (save_as == nullptr) return;
  FixedText<120> value;
  value.add("attachment; filename=\"%s\"", save_as);
  add(response, "Content-Disposition", value.c_str());
}

Response response_of(const HttpAnswer& answer) {
  // The library takes a pointer to what it may not change.
  void* const body = const_cast<char*>(answer.body.data());  // NOLINT(cppcoreguidelines-pro-type-const-cast)
  Response response(MHD_create_response_from_buffer(answer.body.size(), body,
                                                    answer.is_fixed ? MHD_RESPMEM_PERSISTENT : MHD_RESPMEM_MUST_COPY));
  if (!response) return response;
  add_headers(response, answer.type, answer.save_as);
  if (answer.is_gzip) add(response, "Content-Encoding", "gzip");
  if (answer.allow != nullptr) add(response, "Allow", answer.allow);
  if (answer.closes) add(response, "Connection", "close");
  return response;
}

constexpr HttpAnswer refusal(unsigned status, std::string_view body) {
  return {.status = status, .body = body, .is_fixed = true};
}
constexpr HttpAnswer kTooLong = refusal(413, R"({"ok": false, "error": "the request is too long"})");
constexpr HttpAnswer kNoLength = refusal(411, R"({"ok": false, "error": "the request has no Content-Length"})");
constexpr HttpAnswer kTooMany = refusal(503, R"({"ok": false, "error": "too many pages are open: close one"})");

std::string_view header(MHD_Connection* connection, const char* name, MHD_ValueKind kind = MHD_HEADER_KIND) {
  const char* const value = MHD_lookup_connection_value(connection, kind, name);
  return value != nullptr ? value : std::string_view();
}

/// @param encodings  header Accept-Encoding, such as "gzip, deflate;q=0.5". A weight may be 0, so gzip with one is not taken
bool takes_gzip(std::string_view encodings) {
  const std::size_t at = encodings.find("gzip");
  return at != std::string_view::npos && !encodings.substr(at).starts_with("gzip;");
}

}  // namespace

struct HttpServer::Parts {
  /// A connection, from its first byte to its last.
  struct Line {
    MHD_Connection* connection = nullptr;
    HostClock::time_point since;  ///< a request is awaited or an answer is taken
    bool answered = false;
    bool unbounded = false;  ///< it is an event stream, or waits for the printer
    ClientAddress address;
    bool ends = false;  ///< for another one
  };
  /// A request.
  struct Exchange {
    MHD_Connection* connection = nullptr;  ///< null: this one is free
    std::uint64_t number = 0;              ///< differs for each request
    std::array<char, kLongestBody> body{};
    std::size_t filled = 0;
    bool waits = false;    ///< suspended until finish()
    bool streams = false;  ///< its body goes to HttpHandler::take_body()
    bool stuck = false;    ///< suspended until go_on()
    Response response;     ///< of finish()
    unsigned status = 0;
    std::optional<HttpStream> stream;  ///< of HttpServer::begin_stream()
  };
  struct Stream {
    MHD_Connection* connection = nullptr;  ///< null: this one is free
    Parts* parts = nullptr;
    std::size_t place = 0;
    HttpStream what;
    bool begins = false;
    bool sleeps = false;  ///< suspended until wake()
    bool failed = false;
    std::uint64_t sent = 0;
    std::array<char, HttpStream::kRoom> room{};
    std::size_t filled = 0, taken = 0;
  };

  Parts(HttpHandler& to, const HttpTimes& until) : handler(to), times(until) {}

  HttpHandler& handler;
  HttpTimes times;
  MHD_Daemon* daemon = nullptr;
  std::uint64_t requests = 0;
  std::array<Line, kMostConnections> lines;
  std::array<Exchange, kMostConnections> exchanges;
  std::array<Stream, kMostStreams> streams;
  unsigned turned_away = 0;

  static MHD_Result queue(MHD_Connection* connection, unsigned status, const Response& response) {
    return response ? MHD_queue_response(connection, status, response.get()) : MHD_NO;
  }
  static MHD_Result queue(MHD_Connection* connection, const HttpAnswer& answer) {
    return queue(connection, answer.status, response_of(answer));
  }

  Line* line_of(const MHD_Connection* connection) {
    auto* const line =
        std::find_if(lines.begin(), lines.end(), [&](const Line& one) { return one.connection == connection; });
    return line != lines.end() ? line : nullptr;
  }
  void note(const MHD_Connection* connection, bool answered, bool unbounded) {
    Line* const line = line_of(connection);
    if (line == nullptr) return;
    line->since = HostClock::now();
    line->answered = answered;
    line->unbounded = unbounded;
  }

  static ClientAddress address_of(MHD_Connection* connection) {
    const auto* const info = MHD_get_connection_info(connection, MHD_CONNECTION_INFO_CLIENT_ADDRESS);
    return client_address(info != nullptr ? info->client_addr : nullptr);
  }

  static void end(const Line& line) {
    const auto* const info = MHD_get_connection_info(line.connection, MHD_CONNECTION_INFO_CONNECTION_FD);
    if (info != nullptr) static_cast<void>(::shutdown(info->connect_fd, SHUT_RDWR));
  }

  /// Whether a new connection gets a place. Another one may have to make room.
  static MHD_Result on_accept(void* cls, const sockaddr* from, socklen_t /*size*/) {
    auto& parts = *static_cast<Parts*>(cls);
    const ClientAddress address = client_address(from);
    std::array<HeldPlace, kMostConnections> held;
    for (std::size_t i = 0; i < held.size(); ++i) {
      const Line& line = parts.lines[i];
      if (line.connection == nullptr) continue;
      held[i] = {line.address, true, parts.handler.is_paired(line.address), !line.unbounded, line.ends, line.since};
    }
    const auto choice = parts.handler.is_flooding(address)
                            ? PlaceChoice()
                            : choose_place(held, address, parts.handler.is_paired(address), kPlaces);
    if (choice.ends) {
      parts.lines[*choice.ends].ends = true;
      end(parts.lines[*choice.ends]);
    }
    if (!choice.is_let_in) ++parts.turned_away;
    return choice.is_let_in ? MHD_YES : MHD_NO;
  }

  static void on_connection(void* cls, MHD_Connection* connection, void** /*context*/,
                            MHD_ConnectionNotificationCode code) {
    auto& parts = *static_cast<Parts*>(cls);
    const bool begins = code == MHD_CONNECTION_NOTIFY_STARTED;
    Line* const line = parts.line_of(begins ? nullptr : connection);
    if (line == nullptr) return;
    *line = Line();
    if (!begins) return;
    line->connection = connection;
    line->since = HostClock::now();
    line->address = address_of(connection);
  }

  static MHD_Result on_request(void* cls, MHD_Connection* connection, const char* url, const char* method,
                               const char* /*version*/, const char* upload, std::size_t* upload_size, void** context) {
    auto& parts = *static_cast<Parts*>(cls);
    auto* exchange = static_cast<Exchange*>(*context);
    if (exchange == nullptr) {
      exchange = std::find_if(parts.exchanges.begin(), parts.exchanges.end(),
                              [](const Exchange& one) { return one.connection == nullptr; });
      if (exchange == parts.exchanges.end()) return MHD_NO;
      *context = exchange;
      exchange->connection = connection;
      exchange->number = ++parts.requests;
      exchange->filled = 0;
      if (const auto refusal = parts.handler.refuse_early(request_of(*exchange, url, method))) {
        parts.note(connection, true, false);
        return queue(connection, *refusal);
      }
      return parts.handler.streams_body(url) ? parts.begin_body(*exchange, url, method) : begin(parts, connection);
    }
    if (*upload_size > 0 && exchange->streams) return parts.take_body(*exchange, upload, *upload_size);
    if (*upload_size > 0) {
      if (*upload_size > exchange->body.size() - exchange->filled) return MHD_NO;
      std::memcpy(exchange->body.data() + exchange->filled, upload, *upload_size);
      exchange->filled += *upload_size;
      *upload_size = 0;
      return MHD_YES;
    }
    if (exchange->response) return queue(connection, exchange->status, exchange->response);
    if (exchange->stream) return parts.begin_stream(connection, *exchange->stream);
    return parts.dispatch(*exchange, url, method);
  }

  /// Refuses a body that is too long before it comes.
  static MHD_Result begin(Parts& parts, MHD_Connection* connection) {
    if (!header(connection, "Transfer-Encoding").empty()) {
      parts.note(connection, true, false);
      return queue(connection, kNoLength);
    }
    const std::string_view length = header(connection, "Content-Length");
    const auto bytes = to_number<std::uint64_t>(length);
    if (length.empty() || (bytes && *bytes <= kLongestBody)) return MHD_YES;
    parts.note(connection, true, false);
    return queue(connection, kTooLong);
  }

  HttpTicket ticket_of(const Exchange& exchange) const {
    return {static_cast<std::size_t>(&exchange - exchanges.data()), exchange.number};
  }

  /// Lets the handler look at a request whose body goes to it.
  MHD_Result begin_body(Exchange& exchange, const char* url, const char* method) {
    MHD_Connection* const connection = exchange.connection;
    const auto bytes = to_number<std::uint64_t>(header(connection, "Content-Length"));
    const bool has_length = bytes && header(connection, "Transfer-Encoding").empty();
    const auto refusal = has_length ? handler.begin_body(request_of(exchange, url, method), *bytes, ticket_of(exchange))
                                    : std::optional(kNoLength);
    if (refusal) {
      note(connection, true, false);
      return queue(connection, *refusal);
    }
    exchange.streams = true;
    // As long as bytes come: libmicrohttpd ends a connection that is silent, and the printer an upload that is slow.
    note(connection, false, true);
    return MHD_YES;
  }

  MHD_Result take_body(Exchange& exchange, const char* upload, std::size_t& upload_size) {
    const auto taken = handler.take_body(ticket_of(exchange), {upload, upload_size});
    if (!taken) return MHD_NO;
    upload_size -= *taken;
    if (upload_size > 0) {
      exchange.stuck = true;
      MHD_suspend_connection(exchange.connection);
    }
    return MHD_YES;
  }

  static HttpRequest request_of(const Exchange& exchange, const char* url, const char* method) {
    MHD_Connection* const connection = exchange.connection;
    HttpRequest request;
    request.method = method;
    request.path = url;
    request.host = header(connection, "Host");
    request.origin = header(connection, "Origin");
    request.content_type = header(connection, "Content-Type");
    request.token = header(connection, "Plumbline-Token");
    request.takes_gzip = takes_gzip(header(connection, "Accept-Encoding"));
    if (const auto n = to_number<std::uint32_t>(header(connection, "n", MHD_GET_ARGUMENT_KIND))) request.n = *n;
    for (std::size_t i = 0; i < request.window.size(); ++i) {
      constexpr const char* kNames[] = {"x", "y", "step"};
      request.window[i] = to_number<std::uint32_t>(header(connection, kNames[i], MHD_GET_ARGUMENT_KIND)).value_or(0);
    }
    request.address = address_of(connection);
    request.job = header(connection, "job", MHD_GET_ARGUMENT_KIND);
    request.body = {exchange.body.data(), exchange.filled};
    return request;
  }

  MHD_Result dispatch(Exchange& exchange, const char* url, const char* method) {
    MHD_Connection* const connection = exchange.connection;
    const HttpReply reply = handler.answer(request_of(exchange, url, method), ticket_of(exchange));
    if (const auto* const answer = std::get_if<HttpAnswer>(&reply)) {
      note(connection, true, false);
      return queue(connection, *answer);
    }
    note(connection, true, true);
    if (const auto* const stream = std::get_if<HttpStream>(&reply)) return begin_stream(connection, *stream);
    exchange.waits = true;
    MHD_suspend_connection(connection);
    return MHD_YES;
  }

  MHD_Result begin_stream(MHD_Connection* connection, const HttpStream& what) {
    auto* const stream =
        std::find_if(streams.begin(), streams.end(), [](const Stream& one) { return one.connection == nullptr; });
    if (stream == streams.end() || !may_stream(address_of(connection))) {
      note(connection, true, false);
      return queue(connection, kTooMany);
    }
    const bool is_file = what.kind == HttpStream::Kind::kParts;
    const Response response(MHD_create_response_from_callback(is_file ? what.size : MHD_SIZE_UNKNOWN, 4096, on_read,
                                                              stream, on_stream_end));
    if (!response) return MHD_NO;
    stream->connection = connection;
    stream->parts = this;
    stream->place = static_cast<std::size_t>(stream - streams.data());
    stream->what = what;
    stream->begins = true;
    stream->sleeps = stream->failed = false;
    stream->sent = 0;
    stream->filled = stream->taken = 0;
    add_headers(response, what.type, what.save_as);
    return queue(connection, 200, response);
  }

  /// Some streams are kept for paired browsers.
  bool may_stream(const ClientAddress& address) {
    if (handler.is_paired(address)) return true;
    std::size_t unpaired = 0, own = 0;
    for (const Stream& one : streams) {
      if (one.connection == nullptr) continue;
      const ClientAddress whose = address_of(one.connection);
      if (whose == address) ++own;
      if (!handler.is_paired(whose)) ++unpaired;
    }
    return unpaired < kUnpairedStreams && own < kStreamsOfUnpaired;
  }

  static ssize_t on_read(void* cls, std::uint64_t /*position*/, char* out, std::size_t most) {
    auto& stream = *static_cast<Stream*>(cls);
    if (stream.taken == stream.filled) {
      stream.taken = 0;
      const auto filled = stream.failed ? std::nullopt
                                        : stream.parts->handler.fill(stream.place, stream.what, stream.begins,
                                                                     stream.sent, stream.room);
      if (!filled) return MHD_CONTENT_READER_END_WITH_ERROR;
      stream.filled = *filled;
      stream.begins = false;
    }
    const std::size_t bytes = std::min(most, stream.filled - stream.taken);
    std::memcpy(out, stream.room.data() + stream.taken, bytes);
    stream.taken += bytes;
    stream.sent += bytes;
    if (bytes == 0) {
      stream.sleeps = true;
      MHD_suspend_connection(stream.connection);
    }
    return static_cast<ssize_t>(bytes);
  }
  static void on_stream_end(void* cls) { static_cast<Stream*>(cls)->connection = nullptr; }

  static void on_completed(void* cls, MHD_Connection* connection, void** context, MHD_RequestTerminationCode /*code*/) {
    auto* const exchange = static_cast<Exchange*>(*context);
    if (exchange == nullptr) return;
    auto& parts = *static_cast<Parts*>(cls);
    const bool streamed = exchange->streams;
    exchange->connection = nullptr;
    exchange->waits = exchange->streams = exchange->stuck = false;
    exchange->response.reset();
    exchange->stream.reset();
    *context = nullptr;
    parts.note(connection, false, false);
    if (streamed) parts.handler.ended(parts.ticket_of(*exchange));
  }

  /// Ends connections that take too long. Those that send or take nothing at all are ended by libmicrohttpd.
  void end_slow_ones(HostClock::time_point now) const {
    for (const Line& line : lines) {
      if (line.connection == nullptr || line.unbounded) continue;
      if (now - line.since >= (line.answered ? times.answer : times.request)) end(line);
    }
  }
};

HttpServer::HttpServer(std::unique_ptr<Parts> parts) : parts_(std::move(parts)) {}

HttpServer::~HttpServer() {
  for (Parts::Exchange& exchange : parts_->exchanges) {
    if (exchange.waits || exchange.stuck) MHD_resume_connection(exchange.connection);
  }
  for (Parts::Stream& stream : parts_->streams) {
    if (stream.connection != nullptr && stream.sleeps) MHD_resume_connection(stream.connection);
  }
  if (parts_->daemon != nullptr) MHD_stop_daemon(parts_->daemon);
}

Expected<std::unique_ptr<HttpServer>> HttpServer::open(const std::string& address, std::uint16_t port,
                                                       HttpHandler& handler, const HttpTimes& times) {
  const auto socket = listen_at(address, port);
  PLUMBLINE_TRY(socket);
  auto parts = std::make_unique<Parts>(handler, times);
  // The library closes the socket that it gets, so it gets one of its own.
  parts->daemon =
      MHD_start_daemon(MHD_USE_EPOLL | MHD_ALLOW_SUSPEND_RESUME, 0, &Parts::on_accept, parts.get(), &Parts::on_request,
                       parts.get(), MHD_OPTION_LISTEN_SOCKET, ::dup(socket->get()), MHD_OPTION_CONNECTION_LIMIT,
                       kMostConnections, MHD_OPTION_CONNECTION_MEMORY_LIMIT, kConnectionMemory,
                       MHD_OPTION_CONNECTION_TIMEOUT, kIdleSeconds, MHD_OPTION_STRICT_FOR_CLIENT, 1,
                       MHD_OPTION_SIGPIPE_HANDLED_BY_APP, 1, MHD_OPTION_NOTIFY_CONNECTION, &Parts::on_connection,
                       parts.get(), MHD_OPTION_NOTIFY_COMPLETED, &Parts::on_completed, parts.get(), MHD_OPTION_END);
  if (parts->daemon == nullptr) {
    return plumbline::fail(ErrorCode::kCannotOpen, "port %u: libmicrohttpd does not start", port);
  }
  return std::unique_ptr<HttpServer>(new HttpServer(std::move(parts)));
}

std::uint16_t HttpServer::port() const {
  const auto* const info = MHD_get_daemon_info(parts_->daemon, MHD_DAEMON_INFO_LISTEN_FD);
  sockaddr_in6 address{};  // the port is at the same place in an IPv4 address
  socklen_t size = sizeof address;
  if (info == nullptr || ::getsockname(info->listen_fd, reinterpret_cast<sockaddr*>(&address), &size) != 0) return 0;
  return ntohs(address.sin6_port);
}

int HttpServer::descriptor() const { return MHD_get_daemon_info(parts_->daemon, MHD_DAEMON_INFO_EPOLL_FD)->epoll_fd; }

std::chrono::milliseconds HttpServer::patience() const {
  constexpr std::uint64_t kMost = 1000;
  MHD_UNSIGNED_LONG_LONG milliseconds = kMost;
  if (MHD_get_timeout(parts_->daemon, &milliseconds) != MHD_YES) milliseconds = kMost;
  return std::chrono::milliseconds(std::min<std::uint64_t>(milliseconds, kMost));
}

void HttpServer::run() {
  static_cast<void>(MHD_run(parts_->daemon));
  parts_->end_slow_ones(HostClock::now());
}

unsigned HttpServer::take_turned_away() { return std::exchange(parts_->turned_away, 0U); }

void HttpServer::finish(const HttpTicket& ticket, const HttpAnswer& answer) {
  Parts::Exchange& exchange = parts_->exchanges[ticket.place];
  if (exchange.number != ticket.number || !exchange.waits) return;
  exchange.waits = false;
  exchange.response = response_of(answer);
  exchange.status = answer.status;
  parts_->note(exchange.connection, true, false);
  MHD_resume_connection(exchange.connection);
}

void HttpServer::go_on(const HttpTicket& ticket) {
  Parts::Exchange& exchange = parts_->exchanges[ticket.place];
  if (exchange.number != ticket.number || !exchange.stuck) return;
  exchange.stuck = false;
  MHD_resume_connection(exchange.connection);
}

void HttpServer::begin_stream(const HttpTicket& ticket, const HttpStream& stream) {
  Parts::Exchange& exchange = parts_->exchanges[ticket.place];
  if (exchange.number != ticket.number || !exchange.waits) return;
  exchange.waits = false;
  exchange.stream = stream;
  MHD_resume_connection(exchange.connection);
}

void HttpServer::fail(std::size_t stream) {
  parts_->streams[stream].failed = true;
  wake(stream);
}

void HttpServer::wake(std::size_t stream) {
  Parts::Stream& one = parts_->streams[stream];
  if (one.connection == nullptr || !one.sleeps) return;
  one.sleeps = false;
  MHD_resume_connection(one.connection);
}

void HttpServer::wake_all(HttpStream::Kind kind) {
  for (std::size_t i = 0; i < kMostStreams; ++i) {
    if (parts_->streams[i].what.kind == kind) wake(i);
  }
}

}  // namespace plumbline::firmware::inline page
