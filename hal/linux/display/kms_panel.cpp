#include "hal/linux/display/kms_panel.hpp"

#include <fcntl.h>
#include <linux/kd.h>
#include <poll.h>
#include <sys/ioctl.h>

#include <algorithm>
#include <array>
#include <utility>

#include "hal/linux/display/kms_buffer.hpp"
#include "hal/linux/display/kms_output.hpp"

namespace plumbline::inline hal::inline linux_board {

using namespace kms;

namespace {

using HostClock = std::chrono::steady_clock;

/// Keeps the console from drawing text and a cursor on the panel. A board without a console needs none of this.
class GraphicsConsole {
 public:
  GraphicsConsole() = default;
  GraphicsConsole(const GraphicsConsole&) = delete;
  GraphicsConsole& operator=(const GraphicsConsole&) = delete;
  ~GraphicsConsole() {
    if (former_mode_ >= 0) static_cast<void>(::ioctl(file_.get(), KDSETMODE, former_mode_));
  }

  void take() {
    file_ = File(::open("/dev/tty0", O_RDWR | O_CLOEXEC | O_NOCTTY));
    if (file_.get() < 0) return;
    int mode = KD_TEXT;
    if (::ioctl(file_.get(), KDGETMODE, &mode) != 0) return;
    if (::ioctl(file_.get(), KDSETMODE, KD_GRAPHICS) == 0) former_mode_ = mode;
  }

 private:
  File file_{-1};
  int former_mode_ = -1;
};

}  // namespace

/// A display that we hold. Members are destroyed in reverse order: first the output restores the former picture.
class KmsPanel::Device {
 public:
  Device(FoundPanel panel, std::chrono::nanoseconds flip_timeout)
      : panel_(std::move(panel)), flip_timeout_(flip_timeout), output_(panel_) {}
  Device(const Device&) = delete;
  Device& operator=(const Device&) = delete;
  // While a flip is pending the kernel refuses to restore the former picture.
  ~Device() { static_cast<void>(await_flip(HostClock::now() + flip_timeout_)); }

  Status acquire(std::uint32_t plane);
  Expected<std::span<std::uint32_t>> back();
  Status flip();
  std::size_t pitch() const { return buffers_[0].pitch(); }
  CardInUse card() const { return {panel_.card.get(), panel_.path, panel_.crtc}; }
  std::chrono::nanoseconds frame() const {
    const auto& mode = panel_.mode;
    const double hz = mode.clock > 0 ? mode.clock * 1000.0 / (mode.htotal * static_cast<double>(mode.vtotal)) : 60.0;
    return std::chrono::nanoseconds(static_cast<std::int64_t>(1e9 / std::max(hz, 1.0)));
  }

 private:
  /// @returns whether the requested flip has happened
  bool await_flip(HostClock::time_point until);
  static void on_flip(int, unsigned, unsigned, unsigned, void* self) { static_cast<Device*>(self)->pending_ = false; }

  FoundPanel panel_;
  std::chrono::nanoseconds flip_timeout_;
  std::array<Buffer, 2> buffers_;
  GraphicsConsole console_;
  Output output_;
  std::size_t front_ = 0;
  bool pending_ = false;
};

Status KmsPanel::Device::acquire(std::uint32_t plane) {
  PLUMBLINE_TRY(output_.acquire(plane));
  for (auto& buffer : buffers_) {
    auto created = Buffer::create(panel_.card.get(), panel_.mode.hdisplay, panel_.mode.vdisplay);
    PLUMBLINE_TRY(created);
    buffer = std::move(*created);
  }
  console_.take();
  const int result = output_.set_mode(buffers_[front_].frame());
  if (result != 0) return panel_failed("refuses its mode", -result);
  return {};
}

bool KmsPanel::Device::await_flip(HostClock::time_point until) {
  drmEventContext context{};
  context.version = 2;
  context.page_flip_handler = &Device::on_flip;
  while (pending_) {
    const auto left = std::chrono::ceil<std::chrono::milliseconds>(until - HostClock::now()).count();
    pollfd fd{panel_.card.get(), POLLIN, 0};
    const int ready = ::poll(&fd, 1, static_cast<int>(std::max<std::int64_t>(0, left)));
    if (ready > 0 && ::drmHandleEvent(panel_.card.get(), &context) != 0) return false;
    // Other events of the card, or signals, don't extend the wait.
    if (pending_ && left <= 0) return false;
  }
  return true;
}

Expected<std::span<std::uint32_t>> KmsPanel::Device::back() {
  if (!await_flip(HostClock::now() + flip_timeout_)) {
    return fail(ErrorCode::kFlipTimeout, "the panel has still not shown an earlier mask:\tcheck its cable");
  }
  const Buffer& buffer = buffers_[1 - front_];
  return buffer.pixels().first(buffer.pitch() * panel_.mode.vdisplay);
}

Status KmsPanel::Device::flip() {
  const auto until = HostClock::now() + flip_timeout_;
  pending_ = true;
  const int result = output_.request_flip(buffers_[1 - front_].frame(), this);
  if (result != 0) {
    pending_ = false;
    return panel_failed("refuses a flip", -result);
  }
  front_ = 1 - front_;  // it may be scanned out from now on, even if the wait below times out
  if (!await_flip(until)) {
    return fail(ErrorCode::kFlipTimeout, "the panel did not show a mask within %lld ms:\tcheck its cable",
                static_cast<long long>(std::chrono::duration_cast<std::chrono::milliseconds>(flip_timeout_).count()));
  }
  return {};
}

KmsPanel::KmsPanel(std::unique_ptr<Device> device) : device_(std::move(device)) {}
KmsPanel::KmsPanel(KmsPanel&&) noexcept = default;
KmsPanel::~KmsPanel() = default;

Expected<KmsPanel> KmsPanel::open(const DisplaySettings& settings, std::uint32_t width, std::uint32_t height) {
  auto found = find_panel(settings, width, height);
  PLUMBLINE_TRY(found);
  auto device = std::make_unique<Device>(std::move(*found), std::chrono::milliseconds(settings.flip_timeout_ms));
  PLUMBLINE_TRY(device->acquire(settings.plane));
  return KmsPanel(std::move(device));
}

Expected<DisplayFinding> KmsPanel::examine(const DisplaySettings& settings, std::uint32_t width, std::uint32_t height) {
  const auto found = find_panel(settings, width, height);
  PLUMBLINE_TRY(found);
  DisplayFinding finding;
  finding.card = found->path + ", driver " + driver_of(found->card.get());
  finding.mode = mode_name(found->mode);
  finding.atomic = ::drmSetClientCap(found->card.get(), DRM_CLIENT_CAP_ATOMIC, 1) == 0;
  return finding;
}

Expected<std::span<std::uint32_t>> KmsPanel::back() { return device_->back(); }
std::size_t KmsPanel::pitch() const { return device_->pitch(); }
Status KmsPanel::flip() { return device_->flip(); }
std::chrono::nanoseconds KmsPanel::frame() const { return device_->frame(); }
CardInUse KmsPanel::card() const { return device_->card(); }

}  // namespace plumbline::inline hal::inline linux_board
