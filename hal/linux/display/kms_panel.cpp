#include "hal/linux/display/kms_panel.hpp"

#include <drm_fourcc.h>
#include <fcntl.h>
#include <linux/kd.h>
#include <poll.h>
#include <sys/ioctl.h>
#include <sys/mman.h>
#include <unistd.h>

#include <algorithm>
#include <cerrno>
#include <cstring>
#include <optional>
#include <utility>

#include "hal/linux/display/kms_search.hpp"

namespace plumbline {

using namespace kms;

namespace {
using Clock = std::chrono::steady_clock;
}  // namespace

/// The display while it is ours.
class KmsPanel::Device {
 public:
  explicit Device(Found found, std::chrono::nanoseconds flip_timeout)
      : card_(std::move(found.card)),
        connector_(found.connector),
        crtc_(found.crtc),
        crtc_index_(found.crtc_index),
        mode_(found.mode),
        flip_timeout_(flip_timeout) {}
  Device(const Device&) = delete;
  Device& operator=(const Device&) = delete;
  ~Device();

  Status take(std::uint32_t plane);
  Expected<std::span<std::uint32_t>> back();
  Status flip();
  std::size_t pitch() const { return buffers_[0].pitch / sizeof(std::uint32_t); }
  std::chrono::nanoseconds frame() const {
    const double hz =
        mode_.clock > 0 ? mode_.clock * 1000.0 / (mode_.htotal * static_cast<double>(mode_.vtotal)) : 60.0;
    return std::chrono::nanoseconds(static_cast<std::int64_t>(1e9 / std::max(hz, 1.0)));
  }

 private:
  struct Buffer {
    std::uint32_t handle = 0;
    std::uint32_t frame = 0;
    std::uint32_t pitch = 0;  // bytes
    std::uint64_t bytes = 0;
    std::uint32_t* pixels = nullptr;
  };
  /// Numbers of the properties that an atomic request sets.
  struct Atomic {
    std::uint32_t plane = 0;
    std::uint32_t mode_blob = 0;
    std::uint32_t connector_crtc = 0, crtc_mode = 0, crtc_active = 0;
    std::uint32_t plane_frame = 0, plane_crtc = 0;
    std::array<std::uint32_t, 4> source{};
    std::array<std::uint32_t, 4> target{};
  };

  Status make(Buffer& buffer);
  void take_console();
  bool prepare_atomic(std::uint32_t plane);
  std::uint32_t property(std::uint32_t object, std::uint32_t type, const char* name) const;
  std::optional<std::uint64_t> value(std::uint32_t object, std::uint32_t type, const char* name) const;
  std::uint32_t find_plane(std::uint32_t wanted) const;
  int commit_mode();
  int commit_flip();
  /// @returns the flip that was asked for has happened
  bool await_flip(Clock::time_point until);
  static void flipped(int, unsigned, unsigned, unsigned, void* self) { static_cast<Device*>(self)->pending_ = false; }

  File card_;
  File console_{-1};
  std::uint32_t connector_;
  std::uint32_t crtc_;
  std::uint32_t crtc_index_;
  drmModeModeInfo mode_;
  std::chrono::nanoseconds flip_timeout_;
  std::array<Buffer, 2> buffers_{};
  std::size_t front_ = 0;
  bool pending_ = false;
  std::optional<Atomic> atomic_;
  Request request_;  // of a flip; made once: it takes its memory from the heap
  Crtc former_;
  int former_console_mode_ = -1;
};

std::uint32_t KmsPanel::Device::property(std::uint32_t object, std::uint32_t type, const char* name) const {
  const Properties all(::drmModeObjectGetProperties(card_.get(), object, type));
  if (!all) return 0;
  for (std::uint32_t i = 0; i < all->count_props; ++i) {
    const Property property(::drmModeGetProperty(card_.get(), all->props[i]));
    if (property && std::strcmp(property->name, name) == 0) return property->prop_id;
  }
  return 0;
}

std::optional<std::uint64_t> KmsPanel::Device::value(std::uint32_t object, std::uint32_t type, const char* name) const {
  const std::uint32_t wanted = property(object, type, name);
  const Properties all(::drmModeObjectGetProperties(card_.get(), object, type));
  if (!all || wanted == 0) return std::nullopt;
  for (std::uint32_t i = 0; i < all->count_props; ++i) {
    if (all->props[i] == wanted) return all->prop_values[i];
  }
  return std::nullopt;
}

/// @returns 0: there is none
std::uint32_t KmsPanel::Device::find_plane(std::uint32_t wanted) const {
  const Planes planes(::drmModeGetPlaneResources(card_.get()));
  if (!planes) return 0;
  for (std::uint32_t i = 0; i < planes->count_planes; ++i) {
    const Plane plane(::drmModeGetPlane(card_.get(), planes->planes[i]));
    if (!plane || (plane->possible_crtcs & (1U << crtc_index_)) == 0) continue;
    const bool is_it = wanted != 0 ? plane->plane_id == wanted
                                   : value(plane->plane_id, DRM_MODE_OBJECT_PLANE, "type") == DRM_PLANE_TYPE_PRIMARY;
    if (is_it) return plane->plane_id;
  }
  return 0;
}

bool KmsPanel::Device::prepare_atomic(std::uint32_t plane) {
  if (::drmSetClientCap(card_.get(), DRM_CLIENT_CAP_ATOMIC, 1) != 0) return false;
  Atomic atomic;
  atomic.plane = plane;
  atomic.connector_crtc = property(connector_, DRM_MODE_OBJECT_CONNECTOR, "CRTC_ID");
  atomic.crtc_mode = property(crtc_, DRM_MODE_OBJECT_CRTC, "MODE_ID");
  atomic.crtc_active = property(crtc_, DRM_MODE_OBJECT_CRTC, "ACTIVE");
  atomic.plane_frame = property(plane, DRM_MODE_OBJECT_PLANE, "FB_ID");
  atomic.plane_crtc = property(plane, DRM_MODE_OBJECT_PLANE, "CRTC_ID");
  constexpr std::array kSource = {"SRC_X", "SRC_Y", "SRC_W", "SRC_H"};
  constexpr std::array kTarget = {"CRTC_X", "CRTC_Y", "CRTC_W", "CRTC_H"};
  bool all = atomic.connector_crtc != 0 && atomic.crtc_mode != 0 && atomic.crtc_active != 0 &&
             atomic.plane_frame != 0 && atomic.plane_crtc != 0;
  for (std::size_t i = 0; i < 4; ++i) {
    atomic.source[i] = property(plane, DRM_MODE_OBJECT_PLANE, kSource[i]);
    atomic.target[i] = property(plane, DRM_MODE_OBJECT_PLANE, kTarget[i]);
    all = all && atomic.source[i] != 0 && atomic.target[i] != 0;
  }
  all = all && ::drmModeCreatePropertyBlob(card_.get(), &mode_, sizeof mode_, &atomic.mode_blob) == 0;
  request_.reset(::drmModeAtomicAlloc());
  if (!all || !request_) return false;
  atomic_ = atomic;
  return true;
}

Status KmsPanel::Device::make(Buffer& buffer) {
  drm_mode_create_dumb create{};
  create.width = mode_.hdisplay;
  create.height = mode_.vdisplay;
  create.bpp = 32;
  if (::drmIoctl(card_.get(), DRM_IOCTL_MODE_CREATE_DUMB, &create) != 0) return panel_failed("no buffer", errno);
  buffer.handle = create.handle;
  buffer.pitch = create.pitch;
  buffer.bytes = create.size;
  const std::uint32_t handles[4] = {create.handle, 0, 0, 0};
  const std::uint32_t pitches[4] = {create.pitch, 0, 0, 0};
  const std::uint32_t offsets[4] = {0, 0, 0, 0};
  if (::drmModeAddFB2(card_.get(), create.width, create.height, DRM_FORMAT_XRGB8888, handles, pitches, offsets,
                      &buffer.frame, 0) != 0) {
    return panel_failed("no frame of XRGB8888", errno);
  }
  drm_mode_map_dumb map{};
  map.handle = create.handle;
  if (::drmIoctl(card_.get(), DRM_IOCTL_MODE_MAP_DUMB, &map) != 0) return panel_failed("its buffer", errno);
  void* const mapped = ::mmap(nullptr, static_cast<std::size_t>(buffer.bytes), PROT_READ | PROT_WRITE, MAP_SHARED,
                              card_.get(), static_cast<off_t>(map.offset));
  if (mapped == MAP_FAILED) return panel_failed("its buffer's memory", errno);
  buffer.pixels = static_cast<std::uint32_t*>(mapped);
  std::memset(buffer.pixels, 0, static_cast<std::size_t>(buffer.bytes));
  return {};
}

/// So that no text and no cursor is drawn while the panel is a mask. A board without a console has none to take.
void KmsPanel::Device::take_console() {
  console_ = File(::open("/dev/tty0", O_RDWR | O_CLOEXEC | O_NOCTTY));
  if (console_.get() < 0) return;
  int mode = KD_TEXT;
  if (::ioctl(console_.get(), KDGETMODE, &mode) != 0) return;
  if (::ioctl(console_.get(), KDSETMODE, KD_GRAPHICS) == 0) former_console_mode_ = mode;
}

int KmsPanel::Device::commit_mode() {
  if (!atomic_) {
    return ::drmModeSetCrtc(card_.get(), crtc_, buffers_[front_].frame, 0, 0, &connector_, 1, &mode_) == 0 ? 0 : -errno;
  }
  const Request request(::drmModeAtomicAlloc());
  const auto add = [&](std::uint32_t object, std::uint32_t name, std::uint64_t number) {
    return ::drmModeAtomicAddProperty(request.get(), object, name, number) >= 0;
  };
  const auto& a = *atomic_;
  const std::array<std::uint64_t, 4> size = {0, 0, mode_.hdisplay, mode_.vdisplay};
  bool added = request && add(connector_, a.connector_crtc, crtc_) && add(crtc_, a.crtc_mode, a.mode_blob) &&
               add(crtc_, a.crtc_active, 1) && add(a.plane, a.plane_frame, buffers_[front_].frame) &&
               add(a.plane, a.plane_crtc, crtc_);
  for (std::size_t i = 0; i < 4; ++i) {
    added = added && add(a.plane, a.source[i], size[i] << 16U) && add(a.plane, a.target[i], size[i]);
  }
  if (!added) return -ENOMEM;
  return ::drmModeAtomicCommit(card_.get(), request.get(), DRM_MODE_ATOMIC_ALLOW_MODESET, nullptr);
}

Status KmsPanel::Device::take(std::uint32_t plane) {
  if (::drmSetMaster(card_.get()) != 0 && errno != EINVAL) return panel_failed("the display", errno);
  static_cast<void>(::drmSetClientCap(card_.get(), DRM_CLIENT_CAP_UNIVERSAL_PLANES, 1));
  const std::uint32_t found = find_plane(plane);
  if (found == 0 && plane != 0) {
    return fail(ErrorCode::kBadSetting, "the panel: its controller has no plane %u, see modetest", plane);
  }
  if (found == 0 || !prepare_atomic(found)) atomic_.reset();
  for (auto& buffer : buffers_) PLUMBLINE_TRY(make(buffer));
  former_.reset(::drmModeGetCrtc(card_.get(), crtc_));
  take_console();
  const int result = commit_mode();
  if (result != 0) return panel_failed("the mode", -result);
  return {};
}

bool KmsPanel::Device::await_flip(Clock::time_point until) {
  drmEventContext context{};
  context.version = 2;
  context.page_flip_handler = &Device::flipped;
  while (pending_) {
    const auto left = std::chrono::ceil<std::chrono::milliseconds>(until - Clock::now()).count();
    pollfd fd{card_.get(), POLLIN, 0};
    const int ready = ::poll(&fd, 1, static_cast<int>(std::max<std::int64_t>(0, left)));
    if (ready > 0 && ::drmHandleEvent(card_.get(), &context) != 0) return false;
    // Whatever else the card has to tell, or a signal, the wait ends in time.
    if (pending_ && left <= 0) return false;
  }
  return true;
}

Expected<std::span<std::uint32_t>> KmsPanel::Device::back() {
  if (!await_flip(Clock::now() + flip_timeout_)) {
    return fail(ErrorCode::kFlipTimeout, "the panel still has not taken an earlier picture: check its cable");
  }
  const Buffer& buffer = buffers_[1 - front_];
  return std::span(buffer.pixels, std::size_t{buffer.pitch} / sizeof(std::uint32_t) * mode_.vdisplay);
}

int KmsPanel::Device::commit_flip() {
  const Buffer& next = buffers_[1 - front_];
  if (!atomic_) {
    return ::drmModePageFlip(card_.get(), crtc_, next.frame, DRM_MODE_PAGE_FLIP_EVENT, this) == 0 ? 0 : -errno;
  }
  ::drmModeAtomicSetCursor(request_.get(), 0);
  if (::drmModeAtomicAddProperty(request_.get(), atomic_->plane, atomic_->plane_frame, next.frame) < 0) return -ENOMEM;
  return ::drmModeAtomicCommit(card_.get(), request_.get(), DRM_MODE_ATOMIC_NONBLOCK | DRM_MODE_PAGE_FLIP_EVENT, this);
}

Status KmsPanel::Device::flip() {
  const auto until = Clock::now() + flip_timeout_;
  pending_ = true;
  const int result = commit_flip();
  if (result != 0) {
    pending_ = false;
    return panel_failed("a flip", -result);
  }
  front_ = 1 - front_;  // from now on it may be scanned out, whatever the wait ends with
  if (!await_flip(until)) {
    return fail(ErrorCode::kFlipTimeout, "the panel did not take a picture within %lld ms: check its cable",
                static_cast<long long>(std::chrono::duration_cast<std::chrono::milliseconds>(flip_timeout_).count()));
  }
  return {};
}

KmsPanel::Device::~Device() {
  // While a flip is under way the kernel refuses the former picture.
  static_cast<void>(await_flip(Clock::now() + flip_timeout_));
  if (former_ && former_->mode_valid != 0 && former_->buffer_id != 0) {
    static_cast<void>(::drmModeSetCrtc(card_.get(), crtc_, former_->buffer_id, former_->x, former_->y, &connector_, 1,
                                       &former_->mode));
  }
  if (former_console_mode_ >= 0) static_cast<void>(::ioctl(console_.get(), KDSETMODE, former_console_mode_));
  for (const auto& buffer : buffers_) {
    if (buffer.pixels != nullptr) ::munmap(buffer.pixels, static_cast<std::size_t>(buffer.bytes));
    if (buffer.frame != 0) static_cast<void>(::drmModeRmFB(card_.get(), buffer.frame));
    drm_mode_destroy_dumb destroy{};
    destroy.handle = buffer.handle;
    if (buffer.handle != 0) static_cast<void>(::drmIoctl(card_.get(), DRM_IOCTL_MODE_DESTROY_DUMB, &destroy));
  }
  if (atomic_) static_cast<void>(::drmModeDestroyPropertyBlob(card_.get(), atomic_->mode_blob));
}

KmsPanel::KmsPanel(std::unique_ptr<Device> device) : device_(std::move(device)) {}
KmsPanel::KmsPanel(KmsPanel&&) noexcept = default;
KmsPanel::~KmsPanel() = default;

Expected<KmsPanel> KmsPanel::open(const DisplaySettings& settings, std::uint32_t width, std::uint32_t height) {
  auto found = find(settings, width, height);
  PLUMBLINE_TRY(found);
  auto device = std::make_unique<Device>(std::move(*found), settings.flip_timeout);
  PLUMBLINE_TRY(device->take(settings.plane));
  return KmsPanel(std::move(device));
}

Expected<DisplayFinding> KmsPanel::look(const DisplaySettings& settings, std::uint32_t width, std::uint32_t height) {
  const auto found = find(settings, width, height);
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

}  // namespace plumbline
