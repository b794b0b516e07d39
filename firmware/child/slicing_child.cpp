#include "firmware/child/slicing_child.hpp"

#include <fcntl.h>
#include <poll.h>
#include <sys/socket.h>
#include <sys/wait.h>

#include <algorithm>
#include <array>
#include <cerrno>
#include <csignal>
#include <cstring>
#include <utility>

#include "firmware/child/child_protocol.hpp"
#include "hal/process/passed_descriptor.hpp"

namespace plumbline::firmware {
namespace {

using namespace std::chrono_literals;
using ChildClock = std::chrono::steady_clock;

/// How long the template may take to start its threads and drop its rights, on a busy machine.
constexpr auto kStartPatience = 30s;
/// How long a template may take to end, once its socket has closed and again once it has been killed.
constexpr auto kTemplatePatience = 2s;

bool send(const Descriptor& socket, ChildWord word, std::span<const int> descriptors = {}) {
  ChildMessage message;
  message.word = word;
  return send_message(socket.get(), std::as_bytes(std::span(&message, 1)), descriptors);
}

std::optional<ChildMessage> receive(const Descriptor& socket) {
  ChildMessage message;
  const auto received = receive_message(socket.get(), std::as_writable_bytes(std::span(&message, 1)));
  if (!received || received->bytes != sizeof message) return std::nullopt;
  message.reason[sizeof message.reason - 1] = '\0';
  return message;
}

bool is_readable(const Descriptor& socket, std::chrono::milliseconds patience) {
  pollfd file{socket.get(), POLLIN, 0};
  return ::poll(&file, 1, static_cast<int>(patience.count())) > 0;
}

/// @returns whether a child of this process has ended; it is gone then
bool reap(pid_t process, std::chrono::milliseconds patience) {
  for (const auto until = ChildClock::now() + patience;;) {
    const pid_t ended = ::waitpid(process, nullptr, WNOHANG);
    if (ended == process || (ended < 0 && errno != EINTR)) return true;
    if (ChildClock::now() >= until) return false;
    static_cast<void>(::poll(nullptr, 0, 5));
  }
}

}  // namespace

Expected<SlicingChild> SlicingChild::make(std::size_t arena_bytes, std::uint32_t threads, ChildTask task) {
  auto memory = SharedMemory::create(arena_bytes);
  PLUMBLINE_TRY(memory);
  std::array<int, 2> sockets{};
  if (::socketpair(AF_UNIX, SOCK_SEQPACKET | SOCK_CLOEXEC, 0, sockets.data()) != 0) {
    return fail(ErrorCode::kUnsupported, "no socket for the slicing child: %s", std::strerror(errno));
  }
  Descriptor ours(sockets[0]);
  const Descriptor theirs(sockets[1]);
  const pid_t firmware = ::getpid();
  const pid_t process = ::fork();
  if (process == 0) run_child_template(theirs.get(), *memory, threads, task, firmware);
  if (process < 0) return fail(ErrorCode::kUnsupported, "no slicing child: %s", std::strerror(errno));
  // A stopped template takes no messages: nothing waits until it does.
  static_cast<void>(::fcntl(ours.get(), F_SETFL, O_NONBLOCK));
  SlicingChild child(std::move(*memory), std::move(ours), process);
  static_cast<void>(is_readable(child.socket_, kStartPatience));
  const auto first = receive(child.socket_);
  if (!first) return fail(ErrorCode::kUnsupported, "the slicing child ended while it started");
  if (first->word != ChildWord::kReady) return fail(ErrorCode::kUnsupported, "%s", first->reason);
  child.landlock_ = first->landlock != 0;
  return child;
}

SlicingChild::SlicingChild(SlicingChild&& other) noexcept
    : memory_(std::move(other.memory_)),
      socket_(std::move(other.socket_)),
      ends_by_(other.ends_by_),
      template_(std::exchange(other.template_, -1)),
      landlock_(other.landlock_),
      gone_(other.gone_) {}

SlicingChild::~SlicingChild() {
  if (template_ < 0) return;
  socket_ = Descriptor();  // the template ends when its socket does
  end_template(kTemplatePatience);
}

/// Waits for the end of the template, and kills it if that does not come: SIGKILL ends a stopped process, too. The kernel has killed its
/// child by then.
void SlicingChild::end_template(std::chrono::milliseconds patience) {
  if (!reap(template_, patience)) {
    ::kill(template_, SIGKILL);
    static_cast<void>(reap(template_, kTemplatePatience));
  }
  template_ = -1;
}

tl::unexpected<Error> SlicingChild::has_gone() {
  gone_ = true;
  return fail(
      ErrorCode::kDeviceTimeout,
      "scans can't be read any more, since the process that reads them has ended:\tswitch the printer off and on");
}

Status SlicingChild::start(const ScanRequest& request, std::span<const int> files) {
  if (gone_) return has_gone();
  ends_by_.reset();
  MessagePage& page = memory_.page();
  page.request = request;
  page.answer = ScanAnswer();
  page.pictures.clear();
  for (ProposalPicture& picture : page.proposals) picture.clear();
  page.glance.clear();
  page.progress.beats = 0;
  page.progress.stage = 0;
  page.progress.permille = 0;
  return send(socket_, ChildWord::kStart, files) ? Status() : Status(has_gone());
}

Expected<std::optional<int>> SlicingChild::wait(std::chrono::milliseconds patience) {
  if (ends_by_) {
    const auto left = std::chrono::ceil<std::chrono::milliseconds>(*ends_by_ - ChildClock::now());
    patience = std::clamp(left, 0ms, patience);
  }
  if (!gone_ && !is_readable(socket_, patience)) {
    if (!ends_by_ || ChildClock::now() < *ends_by_) return std::nullopt;
    end_template(0ms);
    return has_gone();
  }
  const auto message = gone_ ? std::nullopt : receive(socket_);
  if (!message || message->word != ChildWord::kEnded) return has_gone();
  return message->status;
}

void SlicingChild::kill(std::chrono::milliseconds patience) {
  const auto until = ChildClock::now() + patience;
  if (!ends_by_) static_cast<void>(send(socket_, ChildWord::kKill));
  ends_by_ = std::min(until, ends_by_.value_or(until));
}

}  // namespace plumbline::firmware
