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

constexpr int kKeeperSocket = 3;  // the keeper's descriptor for the socket

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
  // In a process group of its own: Ctrl-C in a terminal must reach only the firmware.
  posix_spawnattr_t attributes;
  ::posix_spawnattr_init(&attributes);
  ::posix_spawnattr_setflags(&attributes, POSIX_SPAWN_SETPGROUP);
  const int failed = ::posix_spawn(&keeper.process_, program.c_str(), &actions, &attributes, arguments, environ);
  ::posix_spawnattr_destroy(&attributes);
  ::posix_spawn_file_actions_destroy(&actions);
  ::close(sockets[1]);
  if (failed != 0) {
    keeper.process_ = -1;
    return fail(ErrorCode::kLampFailed, "%s: can't start the lamp's keeper: %s", program.c_str(),
                std::strerror(failed));
  }
  // The keeper replies once it holds the line.
  PLUMBLINE_TRY(keeper.turn_off());
  return keeper;
}

LampKeeper::LampKeeper(LampKeeper&& other) noexcept
    : socket_(std::exchange(other.socket_, -1)),
      process_(std::exchange(other.process_, -1)),
      request_(other.request_),
      lit_request_(other.lit_request_),
      dark_at_(other.dark_at_),
      gone_(other.gone_),
      notices_(other.notices_),
      notice_count_(other.notice_count_) {}

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
                                 ? 20 * kAnswerMs  // the first reply includes starting the process
                                 : kAnswerMs);
    if (ready < 0 && errno == EINTR) continue;
    KeeperMessage message;
    if (ready <= 0 || ::recv(socket_, &message, sizeof message, 0) != sizeof message) {
      return fail(ErrorCode::kLampFailed, "the lamp's keeper does not answer:\tswitch the printer off and on");
    }
    handle(message);
    const bool answers = message.request == request_;
    if (answers && message.word == KeeperWord::kFailed) {
      return fail(ErrorCode::kLampFailed, "the lamp's keeper could not arm its timer or set the line: nothing was lit");
    }
    // A lamp that goes off by itself also answers a request to turn it off; late replies to older requests don't.
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
    return fail(ErrorCode::kLampFailed, "the lamp's keeper has gone:\tswitch the printer off and on");
  }
  auto lit = await_answer(static_cast<std::uint32_t>(KeeperWord::kLit));
  if (!lit) static_cast<void>(turn_off());
  return lit;
}

Expected<LampKeeper::Nanoseconds> LampKeeper::turn_off() {
  KeeperMessage message;
  message.word = KeeperWord::kTurnOff;
  message.request = ++request_;
  if (!send(socket_, message)) {
    return fail(ErrorCode::kLampFailed, "the lamp's keeper has gone:\tswitch the printer off and on");
  }
  return await_answer(static_cast<std::uint32_t>(KeeperWord::kDark));
}

void LampKeeper::store(Notice::Kind kind, Nanoseconds at) {
  // After 64 unread notices the oldest is of no use.
  if (notice_count_ == notices_.size()) {
    std::move(notices_.begin() + 1, notices_.end(), notices_.begin());
    --notice_count_;
  }
  notices_[notice_count_++] = {kind, at};
}

void LampKeeper::handle(const KeeperMessage& message) {
  const Nanoseconds at(message.nanoseconds);
  switch (message.word) {
    case KeeperWord::kDark:
      if (message.request != lit_request_ || dark_at_) return;
      dark_at_ = at;
      return store(Notice::Kind::kDark, at);
    case KeeperWord::kCoverOpened: return store(Notice::Kind::kCoverOpened, at);
    case KeeperWord::kCoverClosed: return store(Notice::Kind::kCoverClosed, at);
    case KeeperWord::kLight:
    case KeeperWord::kTurnOff:
    case KeeperWord::kLit:
    case KeeperWord::kFailed: return;
  }
}

void LampKeeper::receive() {
  KeeperMessage message;
  ssize_t got = 0;
  while ((got = ::recv(socket_, &message, sizeof message, MSG_DONTWAIT)) == sizeof message) handle(message);
  const bool ended = got == 0 || (got < 0 && errno != EAGAIN && errno != EINTR);
  if (ended && !gone_) {
    gone_ = true;
    store(Notice::Kind::kGone, Nanoseconds());
  }
}

std::optional<LampKeeper::Nanoseconds> LampKeeper::went_dark() {
  receive();
  return dark_at_;
}

std::optional<LampKeeper::Notice> LampKeeper::next_notice() {
  receive();
  if (notice_count_ == 0) return std::nullopt;
  const Notice oldest = notices_.front();
  std::move(notices_.begin() + 1, notices_.begin() + static_cast<std::ptrdiff_t>(notice_count_), notices_.begin());
  --notice_count_;
  return oldest;
}

}  // namespace plumbline
