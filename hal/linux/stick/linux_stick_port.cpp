#include "hal/linux/stick/linux_stick_port.hpp"

#include <unistd.h>

#include <algorithm>
#include <cerrno>
#include <cstring>

#include "hal/linux/events/linux_clock.hpp"

namespace plumbline {
namespace {

tl::unexpected<Error> none() { return fail(ErrorCode::kNoStick, "there is no stick: plug one in"); }
tl::unexpected<Error> pulled() {
  return fail(ErrorCode::kStickGone, "the stick was pulled: plug it in and start again");
}

}  // namespace

LinuxStickPort::LinuxStickPort(StickSettings settings, EventQueue& events, Interlock& interlock)
    : StickPort(interlock), settings_(std::move(settings)), events_(events) {
  unmount_all(settings_.mount_point);  // what a killed run has left
}

Status LinuxStickPort::open() {
  auto sticks = UsbSticks::open(*this);
  PLUMBLINE_TRY(sticks);
  sticks_.emplace(std::move(*sticks));
  while (look_at_) {
    sleep_until_monotonic(*look_at_);
    drain(monotonic_now());
  }
  return {};
}

void LinuxStickPort::arrived(const std::string& place) {
  if (!settings_.port.empty() && place != settings_.port) return;
  if (!place_.empty()) {
    others_.push_back(place);
    return;
  }
  place_ = place;
  look_at_ = monotonic_now();
  give_up_ = *look_at_ + kLongest;
}

void LinuxStickPort::departed(const std::string& place) {
  std::erase(others_, place);
  if (place_.empty() || place != place_) return;
  if (present_) events_.add(EventKind::kStickDeparted, monotonic_now());
  place_.clear();
  present_ = false;
  look_at_.reset();
  if (others_.empty()) return;
  const std::string next = std::move(others_.front());
  others_.erase(others_.begin());
  arrived(next);
}

void LinuxStickPort::drain(std::chrono::nanoseconds now) {
  if (sticks_) sticks_->drain();
  if (!look_at_ || now < *look_at_) return;
  if (block_devices(folder()).empty() && now < give_up_) {
    look_at_ = now + kLook;
    return;
  }
  look_at_.reset();
  present_ = true;
  ++arrivals_;
  events_.add(EventKind::kStickArrived, now);
}

bool LinuxStickPort::there() const { return present_ && ::access(folder().c_str(), F_OK) == 0; }

Expected<StickIdentity> LinuxStickPort::do_identity() const {
  if (!present_) return none();
  return read_identity(folder());
}

Status LinuxStickPort::do_mount(std::span<char> path) {
  if (!there()) return none();
  auto volume = StickVolume::mount(block_devices(folder()), settings_.mount_point);
  if (!volume) return tl::unexpected<Error>(volume.error());
  if (volume->folder().size() >= path.size()) {
    return fail(ErrorCode::kMountFailed, "%s: the name of the mount point is too long", volume->folder().c_str());
  }
  *std::copy(volume->folder().begin(), volume->folder().end(), path.begin()) = '\0';
  volume_.emplace(std::move(*volume));
  mounted_arrival_ = arrivals_;
  return {};
}

void LinuxStickPort::do_unmount() { volume_.reset(); }

Status LinuxStickPort::do_check_mounted() const {
  if (mounted_arrival_ == arrivals_ && there()) return {};
  return pulled();
}

Expected<std::size_t> LinuxStickPort::do_read(int file, std::span<std::byte> buffer) {
  PLUMBLINE_TRY(do_check_mounted());
  // As much as a stick gives in one go: a pull is noticed between two of them, though all is in the kernel's cache.
  constexpr std::size_t kMost = 65536;
  buffer = buffer.first(std::min(buffer.size(), kMost));
  ssize_t got = 0;
  do {
    got = ::read(file, buffer.data(), buffer.size());
  } while (got < 0 && errno == EINTR);
  const int reason = errno;
  PLUMBLINE_TRY(do_check_mounted());
  if (got >= 0) return static_cast<std::size_t>(got);
  // A pulled stick's reads fail a little before its device goes.
  constexpr auto kGoes = std::chrono::seconds(1);
  for (const auto until = monotonic_now() + kGoes; monotonic_now() < until;) {
    sleep_until_monotonic(monotonic_now() + std::chrono::milliseconds(10));
    PLUMBLINE_TRY(do_check_mounted());
  }
  return fail(ErrorCode::kCannotRead,
              "%s: the stick has bad sectors or a damaged file system: copy the scan to another one",
              std::strerror(reason));
}

}  // namespace plumbline
