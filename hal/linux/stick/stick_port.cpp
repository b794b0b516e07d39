#include "hal/linux/stick/stick_port.hpp"

#include <unistd.h>

#include <algorithm>
#include <cerrno>
#include <cstring>

#include "hal/linux/events/clock.hpp"

namespace plumbline::inline hal::inline linux_board {
namespace {

tl::unexpected<Error> no_stick() { return fail(ErrorCode::kNoStick, "no stick:\tplug one in"); }
tl::unexpected<Error> pulled() {
  return fail(ErrorCode::kStickGone, "the stick was pulled:\tplug it in and start again");
}

}  // namespace

LinuxStickPort::LinuxStickPort(StickSettings settings, std::string mount_socket, EventQueue& events,
                               Interlock& interlock)
    : StickPort(interlock), settings_(std::move(settings)), mount_socket_(std::move(mount_socket)), events_(events) {}

Status LinuxStickPort::open() {
  auto sticks = UsbSticks::open(*this);
  PLUMBLINE_TRY(sticks);
  sticks_.emplace(std::move(*sticks));
  while (poll_at_) {
    sleep_until_monotonic(*poll_at_);
    drain(monotonic_now());
  }
  return {};
}

void LinuxStickPort::on_arrived(const std::string& place) {
  if (!settings_.port.empty() && place != settings_.port) return;
  if (!place_.empty()) {
    others_.push_back(place);
    return;
  }
  place_ = place;
  poll_at_ = monotonic_now();
  give_up_ = *poll_at_ + kMaxWait;
}

void LinuxStickPort::on_departed(const std::string& place) {
  std::erase(others_, place);
  if (place_.empty() || place != place_) return;
  if (present_) events_.add(EventKind::kStickDeparted, monotonic_now());
  place_.clear();
  present_ = false;
  poll_at_.reset();
  if (others_.empty()) return;
  const std::string next = std::move(others_.front());
  others_.erase(others_.begin());
  on_arrived(next);
}

void LinuxStickPort::drain(std::chrono::nanoseconds now) {
  if (sticks_) sticks_->drain();
  if (!poll_at_ || now < *poll_at_) return;
  if (block_devices(folder()).empty() && now < give_up_) {
    poll_at_ = now + kPollInterval;
    return;
  }
  poll_at_.reset();
  present_ = true;
  ++arrivals_;
  events_.add(EventKind::kStickArrived, now);
}

bool LinuxStickPort::attached() const { return present_ && ::access(folder().c_str(), F_OK) == 0; }

Expected<StickIdentity> LinuxStickPort::do_identity() const {
  if (!present_) return no_stick();
  return read_identity(folder());
}

Expected<StickParts> LinuxStickPort::do_mount() {
  if (!attached()) return no_stick();
  auto parts = mount_stick(block_devices(folder()), mount_socket_);
  if (parts) mounted_arrival_ = arrivals_;
  return parts;
}

Expected<bool> LinuxStickPort::do_store(const StickReport& report) {
  if (!attached()) return no_stick();
  return store_on_stick(block_devices(folder()), report, mount_socket_);
}

Status LinuxStickPort::do_check_mounted() const {
  if (mounted_arrival_ == arrivals_ && attached()) return {};
  return pulled();
}

Expected<std::size_t> LinuxStickPort::do_read(int file, std::span<std::byte> buffer) {
  PLUMBLINE_TRY(do_check_mounted());
  // Small reads, so that a pull is noticed between two of them even if the kernel has the file in its cache.
  constexpr std::size_t kMost = 65536;
  buffer = buffer.first(std::min(buffer.size(), kMost));
  ssize_t got = 0;
  do {
    got = ::read(file, buffer.data(), buffer.size());
  } while (got < 0 && errno == EINTR);
  const int reason = errno;
  PLUMBLINE_TRY(do_check_mounted());
  if (got >= 0) return static_cast<std::size_t>(got);
  // Reads of a pulled stick fail shortly before its device disappears. Waiting longer only delays the report of a bad sector.
  constexpr auto kGoes = std::chrono::seconds(1);
  for (const auto until = monotonic_now() + kGoes; monotonic_now() < until;) {
    sleep_until_monotonic(monotonic_now() + std::chrono::milliseconds(10));
    PLUMBLINE_TRY(do_check_mounted());
  }
  return fail(ErrorCode::kCannotRead,
              "%s: the stick has bad sectors or a damaged file system:\tcopy the scan to another stick",
              std::strerror(reason));
}

}  // namespace plumbline::inline hal::inline linux_board
