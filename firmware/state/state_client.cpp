#include "firmware/state/state_client.hpp"

#include <sys/socket.h>

#include <algorithm>
#include <cerrno>
#include <utility>

namespace plumbline {

void StateClient::open(Descriptor socket) {
  socket_ = std::move(socket);
  ended_ = false;
  sent_ = 0;
  filled_ = line_size_ = sent_of_out_ = owed_ = 0;
}

void StateClient::drop() { Descriptor gone(std::move(socket_)); }

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

void StateClient::receive() {
  if (ended_ || filled_ == in_.size()) return;
  const ssize_t got = ::recv(socket_.get(), in_.data() + filled_, in_.size() - filled_, MSG_DONTWAIT);
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

}  // namespace plumbline
