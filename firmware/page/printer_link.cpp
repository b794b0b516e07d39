#include "firmware/page/printer_link.hpp"

#include <fcntl.h>
#include <sys/socket.h>

#include <algorithm>
#include <cerrno>
#include <span>
#include <utility>

#include "firmware/state/socket_place.hpp"
#include "firmware/state/state_line.hpp"
#include "hal/process/passed_descriptor.hpp"

namespace plumbline::firmware::inline page {

PrinterLink::PrinterLink(std::string path) : path_(std::move(path)), bytes_(2 * kLongestLine) {}

void PrinterLink::connect(HostClock::time_point now) {
  if (is_open() || (tried_at_ != HostClock::time_point() && now - tried_at_ < kBetweenTries)) return;
  tried_at_ = now;
  const auto place = SocketPlace::at(path_);
  if (!place) return;
  Descriptor socket = place->connect();
  const int flags = socket.is_open() ? ::fcntl(socket.get(), F_GETFL) : -1;
  if (flags < 0 || ::fcntl(socket.get(), F_SETFL, flags | O_NONBLOCK) != 0) return;
  socket_ = std::move(socket);
  taken_ = filled_ = 0;
}

void PrinterLink::end() {
  const Descriptor closed(std::move(socket_));
  socket_ = Descriptor();
}

void PrinterLink::receive() {
  while (is_open()) {
    if (taken_ > 0) {
      std::copy(bytes_.begin() + static_cast<std::ptrdiff_t>(taken_),
                bytes_.begin() + static_cast<std::ptrdiff_t>(filled_), bytes_.begin());
      filled_ -= std::exchange(taken_, 0);
    }
    // Longer than any line: that is no printer.
    if (filled_ == bytes_.size()) {
      if (std::find(bytes_.begin(), bytes_.end(), '\n') == bytes_.end()) end();
      return;
    }
    const ssize_t got = ::recv(socket_.get(), bytes_.data() + filled_, bytes_.size() - filled_, 0);
    if (got < 0 && errno == EINTR) continue;
    if (got < 0 && (errno == EAGAIN || errno == EWOULDBLOCK)) return;
    if (got <= 0) return end();
    filled_ += static_cast<std::size_t>(got);
  }
}

std::optional<std::string_view> PrinterLink::take_line() {
  const std::string_view rest(bytes_.data() + taken_, filled_ - taken_);
  const std::size_t length = rest.find('\n');
  if (length == std::string_view::npos) return std::nullopt;
  taken_ += length + 1;
  return rest.substr(0, length);
}

bool PrinterLink::send(std::string_view line, int file) {
  if (!is_open()) return false;
  if (send_message(socket_.get(), std::as_bytes(std::span(line)), std::span(&file, file >= 0 ? 1 : 0))) return true;
  end();
  return false;
}

}  // namespace plumbline::firmware::inline page
