#include "hal/linux/lamp/lamp_keeper.hpp"

#include <fcntl.h>
#include <poll.h>
#include <spawn.h>
#include <sys/socket.h>
#include <sys/wait.h>
#include <unistd.h>

#include <algorithm>
#include <array>
#include <cerrno>
#include <cstdlib>
#include <cstring>
#include <utility>

#include "hal/linux/lamp/keeper_protocol.hpp"

namespace plumbline {
namespace {

constexpr int kKeeperSocket = 3;  // where the keeper finds it

bool send(int socket, const KeeperMessage& message) {
  return ::send(socket, &message, sizeof message, MSG_NOSIGNAL) == sizeof message;
}

}  // namespace

Expected<LampKeeper> LampKeeper::start(const std::string& program, const std::string& line, const std::string& cover) {
  std::array<int, 2> sockets{};
  if (::socketpair(AF_UNIX, SOCK_SEQPACKET | SOCK_CLOEXEC, 0, sockets.data()) != 0) {
    return fail(ErrorCode::kLampFailed, "no socket for the lamp's keeper: %s", std::strerror(errno));
  }
  LampKeeper keeper;
  keeper.socket_ = sockets[0];
  std::string firmware = std::to_string(::getpid());
  std::string program_copy = program;
  std::string line_copy = line;
  std::string line_option = "--line";
  std::string firmware_option = "--firmware";
  std::string cover_copy = cover;
  std::string cover_option = "--cover";
  char* const arguments[] = {program_copy.data(), line_option.data(),
                             line_copy.data(),    firmware_option.data(),
                             firmware.data(),     cover.empty() ? nullptr : cover_option.data(),
                             cover_copy.data(),   nullptr};
  posix_spawn_file_actions_t actions;
  ::posix_spawn_file_actions_init(&actions);
  ::posix_spawn_file_actions_adddup2(&actions, sockets[1], kKeeperSocket);
  // A group of its own: Ctrl-C in a terminal is the firmware's to handle.
  posix_spawnattr_t attributes;
  ::posix_spawnattr_init(&attributes);
  ::posix_spawnattr_setflags(&attributes, POSIX_SPAWN_SETPGROUP);
  const int failed = ::posix_spawn(&keeper.process_, program.c_str(), &actions, &attributes, arguments, environ);
  ::posix_spawnattr_destroy(&attributes);
  ::posix_spawn_file_actions_destroy(&actions);
  ::close(sockets[1]);
  if (failed != 0) {
    keeper.process_ = -1;
    return fail(ErrorCode::kLampFailed, "%s: the lamp's keeper does not start: %s", program.c_str(),
                std::strerror(failed));
  }
  // It answers when it holds the line.
  PLUMBLINE_TRY(keeper.darken());
  return keeper;
}

LampKeeper::LampKeeper(LampKeeper&& other) noexcept
    : socket_(std::exchange(other.socket_, -1)),
      process_(std::exchange(other.process_, -1)),
      request_(other.request_),
      lit_request_(other.lit_request_),
      dark_at_(other.dark_at_),
      gone_(other.gone_),
      news_(other.news_),
      news_count_(other.news_count_) {}

LampKeeper::~LampKeeper() {
  if (socket_ >= 0) ::close(socket_);
  while (process_ > 0 && ::waitpid(process_, nullptr, 0) < 0 && errno == EINTR) {
  }
}

Expected<LampKeeper::Nanoseconds> LampKeeper::await_answer(std::uint32_t word) {
  for (;;) {
    pollfd fd{socket_, POLLIN, 0};
    const int ready = ::poll(&fd, 1,
                             word == static_cast<std::uint32_t>(KeeperWord::kDark) && request_ == 1
                                 ? 20 * kAnswerMs  // a new process takes its time
                                 : kAnswerMs);
    if (ready < 0 && errno == EINTR) continue;
    KeeperMessage message;
    if (ready <= 0 || ::recv(socket_, &message, sizeof message, 0) != sizeof message) {
      return fail(ErrorCode::kLampFailed, "the lamp's keeper does not answer: switch the printer off and on");
    }
    take(message);
    const bool answers = message.request == request_;
    if (answers && message.word == KeeperWord::kFailed) {
      return fail(ErrorCode::kLampFailed, "the lamp's keeper could not arm its timer or set the line: nothing was lit");
    }
    // The end of a light is an answer to "darken"; what is late and of an older request is none.
    const bool ends_light = message.word == KeeperWord::kDark && message.request == lit_request_;
    if ((answers || ends_light) && static_cast<std::uint32_t>(message.word) == word) {
      return Nanoseconds(message.nanoseconds);
    }
  }
}

Expected<LampKeeper::Nanoseconds> LampKeeper::light(Nanoseconds cure) {
  KeeperMessage message;
  message.word = KeeperWord::kLight;
  message.request = lit_request_ = ++request_;
  message.nanoseconds = cure.count();
  dark_at_.reset();
  if (!send(socket_, message)) {
    return fail(ErrorCode::kLampFailed, "the lamp's keeper has gone: switch the printer off and on");
  }
  auto lit = await_answer(static_cast<std::uint32_t>(KeeperWord::kLit));
  if (!lit) static_cast<void>(darken());
  return lit;
}

Expected<LampKeeper::Nanoseconds> LampKeeper::darken() {
  KeeperMessage message;
  message.word = KeeperWord::kDarken;
  message.request = ++request_;
  if (!send(socket_, message)) {
    return fail(ErrorCode::kLampFailed, "the lamp's keeper has gone: switch the printer off and on");
  }
  return await_answer(static_cast<std::uint32_t>(KeeperWord::kDark));
}

void LampKeeper::keep(News::Kind kind, Nanoseconds at) {
  // 64 changes of the cover that nobody asked for: the oldest ones are of no use any more.
  if (news_count_ == news_.size()) {
    std::move(news_.begin() + 1, news_.end(), news_.begin());
    --news_count_;
  }
  news_[news_count_++] = {kind, at};
}

void LampKeeper::take(const KeeperMessage& message) {
  const Nanoseconds at(message.nanoseconds);
  switch (message.word) {
    case KeeperWord::kDark:
      if (message.request != lit_request_ || dark_at_) return;
      dark_at_ = at;
      return keep(News::Kind::kDark, at);
    case KeeperWord::kCoverOpened: return keep(News::Kind::kCoverOpened, at);
    case KeeperWord::kCoverClosed: return keep(News::Kind::kCoverClosed, at);
    case KeeperWord::kLight:
    case KeeperWord::kDarken:
    case KeeperWord::kLit:
    case KeeperWord::kFailed: return;
  }
}

void LampKeeper::listen() {
  KeeperMessage message;
  ssize_t got = 0;
  while ((got = ::recv(socket_, &message, sizeof message, MSG_DONTWAIT)) == sizeof message) take(message);
  const bool ended = got == 0 || (got < 0 && errno != EAGAIN && errno != EINTR);
  if (ended && !gone_) {
    gone_ = true;
    keep(News::Kind::kGone, Nanoseconds());
  }
}

std::optional<LampKeeper::Nanoseconds> LampKeeper::went_dark() {
  listen();
  return dark_at_;
}

std::optional<LampKeeper::News> LampKeeper::next_news() {
  listen();
  if (news_count_ == 0) return std::nullopt;
  const News oldest = news_.front();
  std::move(news_.begin() + 1, news_.begin() + static_cast<std::ptrdiff_t>(news_count_), news_.begin());
  --news_count_;
  return oldest;
}

}  // namespace plumbline
