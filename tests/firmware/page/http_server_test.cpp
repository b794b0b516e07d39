/// The server with clients that are slow, and answers that come late or bit by bit. Program.page has those that mean harm.

#include "firmware/page/http_server.hpp"

#include <gmock/gmock.h>
#include <gtest/gtest.h>
#include <netinet/in.h>
#include <poll.h>
#include <sys/socket.h>

#include <algorithm>
#include <csignal>
#include <string>
#include <thread>

#include "firmware/io/descriptor.hpp"

namespace plumbline::firmware {
namespace {

using namespace std::chrono_literals;
using ::testing::EndsWith;
using ::testing::HasSubstr;
using ::testing::StartsWith;

class HttpServerTest : public testing::Test, public HttpHandler {
 protected:
  HttpReply answer(const HttpRequest& request, const HttpTicket& ticket) override {
    ticket_ = ticket;
    seen_ = std::string(request.method) + " " + std::string(request.path) + " " + std::string(request.body);
    if (request.path == "/late") return HttpLater{};
    if (request.path == "/stream")
      return HttpStream{.kind = HttpStream::Kind::kParts, .size = 10, .type = "text/plain"};
    return HttpAnswer{.body = "{}"};
  }
  std::optional<std::size_t> fill(std::size_t stream, const HttpStream& /*what*/, bool begins, std::uint64_t sent,
                                  std::span<char> out) override {
    EXPECT_EQ(begins, sent == 0 && parts_ == 0);
    stream_ = stream;
    if (parts_ % 2 == 1 && parts_++ > 0) return 0;  // sleeps after each part
    ++parts_;
    std::string_view("hello").copy(out.data(), 5);
    return 5;
  }

  bool streams_body(std::string_view path) override { return path == "/body"; }
  std::optional<HttpAnswer> begin_body(const HttpRequest& request, std::uint64_t bytes,
                                       const HttpTicket& ticket) override {
    if (request.token != "known") return HttpAnswer{.status = 401, .body = "refused"};
    ticket_ = ticket;
    announced_ = bytes;
    return std::nullopt;
  }
  /// 500 bytes at a time, and none of a body that breaks off.
  std::optional<std::size_t> take_body(const HttpTicket& ticket, std::span<const char> bytes) override {
    EXPECT_EQ(ticket.number, ticket_.number);
    if (bytes[0] == '!') return std::nullopt;
    const std::size_t taken = std::min<std::size_t>(bytes.size(), 500);
    body_.append(bytes.data(), taken);
    return taken;
  }
  void ended(const HttpTicket& ticket) override { ended_ = ticket.number; }

  Descriptor connect() const {
    Descriptor line(::socket(AF_INET, SOCK_STREAM | SOCK_CLOEXEC, 0));
    sockaddr_in to{};
    to.sin_family = AF_INET;
    to.sin_port = htons(server_->port());
    to.sin_addr.s_addr = htonl(INADDR_LOOPBACK);
    EXPECT_EQ(::connect(line.get(), reinterpret_cast<const sockaddr*>(&to), sizeof to), 0);
    return line;
  }
  static void send(const Descriptor& line, std::string_view text) {
    static_cast<void>(::send(line.get(), text.data(), text.size(), MSG_NOSIGNAL));
  }
  /// Serves until holds() or for `most`. @returns whether it holds
  template <class Holds>
  bool serve_until(Holds holds, std::chrono::milliseconds most = 5s) {
    const auto end = HttpServer::HostClock::now() + most;
    while (!holds() && HttpServer::HostClock::now() < end) {
      pollfd file{.fd = server_->descriptor(), .events = POLLIN, .revents = 0};
      static_cast<void>(::poll(&file, 1, 5));
      server_->run();
    }
    return holds();
  }
  /// Adds what has come to `got`. @returns whether the connection has ended
  static bool receive(const Descriptor& line, std::string& got) {
    char bytes[4096];
    for (;;) {
      const ssize_t size = ::recv(line.get(), bytes, sizeof bytes, MSG_DONTWAIT);
      if (size <= 0) return size == 0 || (errno != EAGAIN && errno != EWOULDBLOCK);
      got.append(bytes, static_cast<std::size_t>(size));
    }
  }

  std::unique_ptr<HttpServer> server_ =
      HttpServer::open("127.0.0.1", 0, *this, {.request = 300ms, .answer = 10s}).value();
  HttpTicket ticket_;
  std::string seen_;
  std::size_t stream_ = 0;
  int parts_ = 0;
  std::uint64_t announced_ = 0, ended_ = 0;
  std::string body_;
};

TEST_F(HttpServerTest, HandsOnALongBodyAsFastAsItIsTaken) {
  const Descriptor line = connect();
  constexpr std::size_t kBytes = 5000;  // longer than another request's may be
  send(line, "POST /body HTTP/1.1\r\nHost: x\r\nPlumbline-Token: known\r\nContent-Length: 5000\r\n\r\n");
  send(line, std::string(kBytes, 'x'));
  ASSERT_TRUE(serve_until([&] { return body_.size() == 500; }));
  EXPECT_EQ(announced_, kBytes);
  EXPECT_FALSE(serve_until([&] { return body_.size() > 500; }, 400ms)) << "longer than a request may take to come";
  server_->go_on({ticket_.place, ticket_.number + 1});
  EXPECT_FALSE(serve_until([&] { return body_.size() > 500; }, 50ms)) << "another's";
  ASSERT_TRUE(serve_until([&] {
    server_->go_on(ticket_);
    return !seen_.empty();
  }));
  EXPECT_EQ(body_, std::string(kBytes, 'x'));
  EXPECT_EQ(seen_, "POST /body ") << "it is answered when all has come";
  std::string got;
  ASSERT_TRUE(serve_until([&] {
    receive(line, got);
    return ended_ == ticket_.number;
  }));
  EXPECT_THAT(got, StartsWith("HTTP/1.1 200 "));
}

TEST_F(HttpServerTest, EndsALongBodyThatIsNotTakenAndForgetsWhoseConnectionEnds) {
  const std::string head = "POST /body HTTP/1.1\r\nHost: x\r\nContent-Length: 5000\r\nPlumbline-Token: ";
  std::string got;
  const Descriptor unknown = connect();
  send(unknown, head + "x\r\n\r\n");
  ASSERT_TRUE(serve_until([&] { return receive(unknown, got) || got.ends_with("refused"); }));
  EXPECT_THAT(got, StartsWith("HTTP/1.1 401 "));
  EXPECT_EQ(announced_, 0U);
  const Descriptor broken = connect();
  send(broken, head + "known\r\n\r\n!");
  ASSERT_TRUE(serve_until([&] { return receive(broken, got); }));
  ASSERT_NE(ticket_.number, 0U);
  EXPECT_EQ(ended_, ticket_.number);
  const std::uint64_t before = ticket_.number;
  {
    const Descriptor gone = connect();
    send(gone, head + "known\r\n\r\nx");
    ASSERT_TRUE(serve_until([&] { return body_ == "x"; }));
  }
  EXPECT_TRUE(serve_until([&] { return ended_ == ticket_.number && ended_ != before; }));
  EXPECT_EQ(seen_, "");
}

TEST_F(HttpServerTest, EndsARequestThatTakesTooLong) {
  const Descriptor slow = connect();
  std::string got;
  const auto began = HttpServer::HostClock::now();
  ASSERT_TRUE(serve_until([&] {
    send(slow, "G");  // never idle, never whole, and never as much as a request may have
    std::this_thread::sleep_for(1ms);
    return receive(slow, got);
  }));
  EXPECT_GE(HttpServer::HostClock::now() - began, 250ms);
  EXPECT_EQ(seen_, "");
}

TEST_F(HttpServerTest, AnswersLateAndForgetsWhoHasGone) {
  const Descriptor line = connect();
  send(line, "POST /late HTTP/1.1\r\nHost: x\r\nContent-Length: 3\r\n\r\nabc");
  ASSERT_TRUE(serve_until([&] { return !seen_.empty(); }));
  EXPECT_EQ(seen_, "POST /late abc");
  std::string got;
  EXPECT_FALSE(serve_until([&] { return receive(line, got); }, 500ms)) << "its request is whole: it may wait";
  server_->finish({ticket_.place, ticket_.number + 1}, {.body = "another's"});
  server_->finish(ticket_, {.status = 409, .body = "here"});
  server_->finish(ticket_, {.body = "twice"});
  ASSERT_TRUE(serve_until([&] {
    receive(line, got);
    return got.find("here") != std::string::npos;
  })) << got;
  EXPECT_THAT(got, StartsWith("HTTP/1.1 409 "));
  const HttpTicket gone = ticket_;
  server_->finish(gone, {.body = "too late"});
}

TEST_F(HttpServerTest, SendsAStreamBitByBitAndSaysThatOneFailed) {
  for (const bool fails : {false, true}) {
    parts_ = 0;
    const Descriptor line = connect();
    send(line, "GET /stream HTTP/1.1\r\nHost: x\r\nConnection: close\r\n\r\n");
    std::string got;
    ASSERT_TRUE(serve_until([&] { return parts_ == 2; }));
    if (fails) {
      server_->fail(stream_);
    } else {
      server_->wake(stream_);
    }
    ASSERT_TRUE(serve_until([&] { return receive(line, got); })) << got;
    EXPECT_THAT(got, HasSubstr("Content-Length: 10\r\n"));
    EXPECT_THAT(got, EndsWith(fails ? "\r\n\r\nhello" : "\r\n\r\nhellohello"));
  }
}

TEST(HttpServer, SaysWhyItCantListen) {
  class Nobody final : public HttpHandler {
    HttpReply answer(const HttpRequest&, const HttpTicket&) override { return HttpAnswer{}; }
    std::optional<std::size_t> fill(std::size_t, const HttpStream&, bool, std::uint64_t, std::span<char>) override {
      return std::nullopt;
    }
  } nobody;
  const auto first = HttpServer::open("127.0.0.1", 0, nobody).value();
  const auto second = HttpServer::open("127.0.0.1", first->port(), nobody);
  ASSERT_FALSE(second);
  EXPECT_THAT(second.error().message(), HasSubstr("page_port"));
  EXPECT_THAT(HttpServer::open("localhost", 0, nobody).error().message(), HasSubstr("is not an address"));
}

}  // namespace
}  // namespace plumbline::firmware
