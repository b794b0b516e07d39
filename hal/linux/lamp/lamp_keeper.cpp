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
#include <csignal>
#include <cstdlib>
#include <cstring>
#include <utility>
#include <vector>

#include "hal/linux/keeper/keeper_protocol.hpp"

namespace plumbline::inline hal::inline linux_board {
namespace {

/// Two connected sockets. `theirs` is above kKeeperWatchSocket, because spawn() copies sockets to the numbers up to there.
struct SocketPair {
  int ours = -1;
  int theirs = -1;
};
SocketPair make_sockets() {
  std::array<int, 2> sockets{-1, -1};
  if (::socketpair(AF_UNIX, SOCK_SEQPACKET | SOCK_CLOEXEC, 0, sockets.data()) != 0) return {};
  const SocketPair pair{sockets[0], ::fcntl(sockets[1], F_DUPFD_CLOEXEC, 10)};
  ::close(sockets[1]);
  return pair;
}

bool send(int socket, const KeeperMessage& message) {
  return ::send(socket, &message, sizeof message, MSG_NOSIGNAL) == sizeof message;
}

std::vector<std::string> arguments_of(const LampKeeper::Settings& settings) {
  std::vector<std::string> words = {settings.program, "--firmware", std::to_string(::getpid()), "--line",
                                    settings.line};
  const auto add = [&](const char* option, std::string value) {
    words.emplace_back(option);
    words.push_back(std::move(value));
  };
  if (!settings.cover.empty()) add("--cover", settings.cover);
  if (!settings.watchdog.empty()) {
    add("--watchdog", settings.watchdog);
    add("--watchdog-s", std::to_string(settings.watchdog_timeout.count()));
  }
  add("--longest-ns", std::to_string(settings.limits.longest.count()));
  add("--per-minute-ns", std::to_string(settings.limits.per_minute.count()));
  add("--lit-ns", std::to_string(settings.lit_before.count()));
  return words;
}

/// @returns an error number, or 0
int spawn(const LampKeeper::Settings& settings, int socket, int watch_socket, pid_t& process) {
  auto words = arguments_of(settings);
  std::vector<char*> arguments;
  for (auto& word : words) arguments.push_back(word.data());
  arguments.push_back(nullptr);
  posix_spawn_file_actions_t actions;
  ::posix_spawn_file_actions_init(&actions);
  ::posix_spawn_file_actions_adddup2(&actions, socket, kKeeperSocket);
  ::posix_spawn_file_actions_adddup2(&actions, watch_socket, kKeeperWatchSocket);
  // In a process group of its own: Ctrl-C in a terminal must reach only the firmware.
  posix_spawnattr_t attributes;
  ::posix_spawnattr_init(&attributes);
  ::posix_spawnattr_setflags(&attributes, POSIX_SPAWN_SETPGROUP);
  const int failed =
      ::posix_spawn(&process, settings.program.c_str(), &actions, &attributes, arguments.data(), environ);
  ::posix_spawnattr_destroy(&attributes);
  ::posix_spawn_file_actions_destroy(&actions);
  return failed;
}

}  // namespace

Expected<LampKeeper> LampKeeper::start(const Settings& settings) {
  const SocketPair requests = make_sockets();
  const SocketPair watch = make_sockets();
  LampKeeper keeper;
  keeper.socket_ = requests.ours;
  const int failed =
      watch.theirs < 0 || requests.theirs < 0 ? errno : spawn(settings, requests.theirs, watch.theirs, keeper.process_);
  for (const int fd : {requests.theirs, watch.theirs}) {
    if (fd >= 0) ::close(fd);
  }
  if (failed != 0) keeper.process_ = -1;
  // The keeper replies once it holds the line.
  const auto answer = failed != 0 ? fail(ErrorCode::kLampFailed, "%s: can't start the lamp's keeper: %s",
                                         settings.program.c_str(), std::strerror(failed))
                                  : keeper.turn_off();
  if (!answer) {
    if (watch.ours >= 0) ::close(watch.ours);
    return tl::unexpected<Error>(answer.error());
  }
  keeper.guard_ = std::make_unique<KeeperGuard>(keeper.process_, watch.ours, settings.line);
  return keeper;
}

LampKeeper::LampKeeper(LampKeeper&& other) noexcept
    : socket_(std::exchange(other.socket_, -1)),
      process_(std::exchange(other.process_, -1)),
      guard_(std::move(other.guard_)),
      request_(other.request_),
      lit_request_(other.lit_request_),
      dark_at_(other.dark_at_),
      gone_(other.gone_),
      notices_(other.notices_),
      notice_count_(other.notice_count_) {}

LampKeeper::~LampKeeper() {
  if (guard_) {
    guard_->expect_end();
    KeeperMessage message;
    message.word = KeeperWord::kEnd;
    static_cast<void>(send(socket_, message));
    guard_.reset();
  } else if (process_ > 0) {
    // It never answered, so it has lit nothing.
    ::kill(process_, SIGKILL);
    while (::waitpid(process_, nullptr, 0) < 0 && errno == EINTR) {
    }
  }
  if (socket_ >= 0) ::close(socket_);
}

tl::unexpected<Error> LampKeeper::no_answer() {
  if (guard_) guard_->give_up();
  return fail(ErrorCode::kLampFailed, "the lamp's keeper does not answer:\tswitch the printer off and on");
}

Expected<LampKeeper::Nanoseconds> LampKeeper::await_answer(std::uint32_t word) {
  for (;;) {
    pollfd fd{socket_, POLLIN, 0};
    // The first reply includes starting the process.
    const int ready = ::poll(&fd, 1, guard_ ? kAnswerMs : kStartMs);
    if (ready < 0 && errno == EINTR) continue;
    KeeperMessage message;
    if (ready <= 0 || ::recv(socket_, &message, sizeof message, 0) != sizeof message) return no_answer();
    handle(message);
    const bool answers = message.request == request_;
    if (answers && message.word == KeeperWord::kFailed) {
      return fail(ErrorCode::kLampFailed, "the lamp's keeper could not arm its timer or set the line: nothing was lit");
    }
    if (answers && message.word == KeeperWord::kRefused) {
      return fail(ErrorCode::kExposureTooLong,
                  "the lamp's keeper refused an exposure, and nothing was lit: it is above max_exposure_s or "
                  "max_light_per_minute_s in the board file's [lamp]");
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
  guard_->watch_closely(true);
  if (!send(socket_, message)) return no_answer();
  auto lit = await_answer(static_cast<std::uint32_t>(KeeperWord::kLit));
  // The second request ends the light that a late or lost reply may have meant.
  if (!lit && turn_off()) guard_->watch_closely(false);
  return lit;
}

Expected<LampKeeper::Nanoseconds> LampKeeper::turn_off() {
  KeeperMessage message;
  message.word = KeeperWord::kTurnOff;
  message.request = ++request_;
  if (!send(socket_, message)) return no_answer();
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
      guard_->watch_closely(false);
      return store(Notice::Kind::kDark, at);
    case KeeperWord::kCoverOpened: return store(Notice::Kind::kCoverOpened, at);
    case KeeperWord::kCoverClosed: return store(Notice::Kind::kCoverClosed, at);
    case KeeperWord::kLight:
    case KeeperWord::kTurnOff:
    case KeeperWord::kEnd:
    case KeeperWord::kLit:
    case KeeperWord::kFailed:
    case KeeperWord::kRefused: return;
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

}  // namespace plumbline::inline hal::inline linux_board
