#include "firmware/state/state_client.hpp"

#include <poll.h>
#include <sys/socket.h>

#include <algorithm>
#include <array>
#include <cerrno>
#include <cstring>
#include <utility>

namespace plumbline::firmware::inline state {

bool StateClient::has_gone(const Descriptor& socket) {
  pollfd file{.fd = socket.get(), .events = 0, .revents = 0};
  return ::poll(&file, 1, 0) > 0 && (static_cast<unsigned>(file.revents) & static_cast<unsigned>(POLLHUP)) != 0;
}

void StateClient::open(Descriptor socket, bool may_hand_over) {
  socket_ = std::move(socket);
  may_hand_over_ = may_hand_over;
  handed_ = Descriptor();
  ended_ = false;
  sent_ = 0;
  filled_ = line_size_ = sent_of_out_ = owed_ = 0;
}

void StateClient::drop() { const Descriptor gone(std::move(socket_)), handed(std::move(handed_)); }

bool StateClient::flush(HostClock::time_point now, HostClock::duration patience) {
  while (owed_ > 0) {
    const ssize_t put = ::send(socket_.get(), out_.data() + sent_of_out_, owed_, MSG_DONTWAIT | MSG_NOSIGNAL);
    if (put < 0 && errno == EINTR) continue;
    if (put < 0) {
      if (errno != EAGAIN || now - stuck_since_ > patience) drop();
      return false;
    }
    stuck_since_ = now;
    sent_of_out_ += static_cast<std::size_t>(put);
    owed_ -= static_cast<std::size_t>(put);
  }
  sent_of_out_ = 0;
  return true;
}

void StateClient::send(std::string_view line) {
  if (!is_open()) return;
  if (owed_ == 0) {
    const ssize_t put = ::send(socket_.get(), line.data(), line.size(), MSG_DONTWAIT | MSG_NOSIGNAL);
    if (put < 0 && errno != EAGAIN && errno != EINTR) return drop();
    line.remove_prefix(put < 0 ? 0 : static_cast<std::size_t>(put));
    if (line.empty()) return;
    stuck_since_ = HostClock::now();
    sent_of_out_ = 0;
  } else if (sent_of_out_ > 0) {
    std::copy_n(out_.begin() + static_cast<std::ptrdiff_t>(sent_of_out_), owed_, out_.begin());
    sent_of_out_ = 0;
  }
  if (line.size() > out_.size() - owed_) return drop();
  line.copy(out_.data() + owed_, line.size());
  owed_ += line.size();
}

void StateClient::send_state(std::string_view line, std::uint64_t sequence) {
  if (owed_ > 0 || sent_ == sequence) return;
  sent_ = sequence;
  send(line);
}

/// As recv(2), into in_. Of the descriptors that come along the last one is kept and all others are closed.
ssize_t StateClient::receive_with_descriptors() {
  constexpr std::size_t kMost = 4;  // that one message may bring: the kernel closes the others
  alignas(cmsghdr) std::array<char, CMSG_SPACE(kMost * sizeof(int))> room{};
  iovec bytes{.iov_base = in_.data() + filled_, .iov_len = in_.size() - filled_};
  msghdr message{};
  message.msg_iov = &bytes;
  message.msg_iovlen = 1;
  message.msg_control = room.data();
  message.msg_controllen = room.size();
  const ssize_t got = ::recvmsg(socket_.get(), &message, MSG_DONTWAIT | MSG_CMSG_CLOEXEC);
  if (got < 0) return got;
  for (const cmsghdr* part = CMSG_FIRSTHDR(&message); part != nullptr;
       part = CMSG_NXTHDR(&message, const_cast<cmsghdr*>(part))) {  // NOLINT(cppcoreguidelines-pro-type-const-cast)
    if (part->cmsg_level != SOL_SOCKET || part->cmsg_type != SCM_RIGHTS) continue;
    const std::size_t count = (part->cmsg_len - CMSG_LEN(0)) / sizeof(int);
    for (std::size_t i = 0; i < count; ++i) {
      int file = -1;
      std::memcpy(&file, CMSG_DATA(part) + i * sizeof file, sizeof file);
      const Descriptor before = std::exchange(handed_, Descriptor(file));
    }
  }
  return got;
}

void StateClient::receive() {
  if (ended_ || filled_ == in_.size()) return;
  // Without room for them the kernel closes descriptors that come along.
  const ssize_t got = may_hand_over_ ? receive_with_descriptors()
                                     : ::recv(socket_.get(), in_.data() + filled_, in_.size() - filled_, MSG_DONTWAIT);
  if (got > 0) filled_ += static_cast<std::size_t>(got);
  if (got == 0) ended_ = true;
  if (got < 0 && errno != EAGAIN && errno != EINTR) drop();
}

std::optional<std::string_view> StateClient::line() {
  receive();
  const auto* const end = std::find(in_.begin(), in_.begin() + static_cast<std::ptrdiff_t>(filled_), '\n');
  if (end == in_.begin() + static_cast<std::ptrdiff_t>(filled_)) return std::nullopt;
  line_size_ = static_cast<std::size_t>(end - in_.begin()) + 1;
  return std::string_view(in_.data(), line_size_ - 1);
}

void StateClient::take_line() {
  std::copy(in_.begin() + static_cast<std::ptrdiff_t>(line_size_), in_.begin() + static_cast<std::ptrdiff_t>(filled_),
            in_.begin());
  filled_ -= line_size_;
  line_size_ = 0;
}

}  // namespace plumbline::firmware::inline state
