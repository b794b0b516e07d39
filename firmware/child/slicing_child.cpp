#include "firmware/child/slicing_child.hpp"

#include <poll.h>
#include <sys/socket.h>
#include <sys/wait.h>

#include <array>
#include <cerrno>
#include <cstring>
#include <utility>

#include "firmware/child/child_protocol.hpp"
#include "hal/process/passed_descriptor.hpp"

namespace plumbline {
namespace {

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
  SlicingChild child(std::move(*memory), std::move(ours), process);
  const auto first = receive(child.socket_);
  if (!first) return fail(ErrorCode::kUnsupported, "the slicing child ended while it started");
  if (first->word != ChildWord::kReady) return fail(ErrorCode::kUnsupported, "%s", first->reason);
  child.landlock_ = first->landlock != 0;
  return child;
}

SlicingChild::SlicingChild(SlicingChild&& other) noexcept
    : memory_(std::move(other.memory_)),
      socket_(std::move(other.socket_)),
      template_(std::exchange(other.template_, -1)),
      landlock_(other.landlock_),
      gone_(other.gone_) {}

SlicingChild::~SlicingChild() {
  if (template_ < 0) return;
  socket_ = Descriptor();  // the template ends when its socket does
  while (::waitpid(template_, nullptr, 0) < 0 && errno == EINTR) {
  }
}

tl::unexpected<Error> SlicingChild::has_gone() {
  gone_ = true;
  return fail(
      ErrorCode::kDeviceTimeout,
      "scans can't be read any more, since the process that reads them has ended:\tswitch the printer off and on");
}

Status SlicingChild::start(const ScanRequest& request, std::span<const int> files) {
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
  pollfd file{socket_.get(), POLLIN, 0};
  if (::poll(&file, 1, static_cast<int>(patience.count())) <= 0) return std::nullopt;
  const auto message = receive(socket_);
  if (!message || message->word != ChildWord::kEnded) return has_gone();
  return message->status;
}

void SlicingChild::kill() { static_cast<void>(send(socket_, ChildWord::kKill)); }

}  // namespace plumbline
