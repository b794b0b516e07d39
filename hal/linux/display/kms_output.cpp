#include "hal/linux/display/kms_output.hpp"

#include <cerrno>
#include <cstring>

namespace plumbline::inline hal::inline linux_board::kms {

std::uint32_t Output::property(std::uint32_t object, std::uint32_t type, const char* name) const {
  const Properties all(::drmModeObjectGetProperties(card(), object, type));
  if (!all) return 0;
  for (std::uint32_t i = 0; i < all->count_props; ++i) {
    const Property property(::drmModeGetProperty(card(), all->props[i]));
    if (property && std::strcmp(property->name, name) == 0) return property->prop_id;
  }
  return 0;
}

std::optional<std::uint64_t> Output::value(std::uint32_t object, std::uint32_t type, const char* name) const {
  const std::uint32_t wanted = property(object, type, name);
  const Properties all(::drmModeObjectGetProperties(card(), object, type));
  if (!all || wanted == 0) return std::nullopt;
  for (std::uint32_t i = 0; i < all->count_props; ++i) {
    if (all->props[i] == wanted) return all->prop_values[i];
  }
  return std::nullopt;
}

/// @returns 0 if there is none
std::uint32_t Output::find_plane(std::uint32_t wanted) const {
  const Planes planes(::drmModeGetPlaneResources(card()));
  if (!planes) return 0;
  for (std::uint32_t i = 0; i < planes->count_planes; ++i) {
    const Plane plane(::drmModeGetPlane(card(), planes->planes[i]));
    if (!plane || (plane->possible_crtcs & (1U << panel_.crtc_index)) == 0) continue;
    const bool is_it = wanted != 0 ? plane->plane_id == wanted
                                   : value(plane->plane_id, DRM_MODE_OBJECT_PLANE, "type") == DRM_PLANE_TYPE_PRIMARY;
    if (is_it) return plane->plane_id;
  }
  return 0;
}

bool Output::prepare_atomic(std::uint32_t plane) {
  if (::drmSetClientCap(card(), DRM_CLIENT_CAP_ATOMIC, 1) != 0) return false;
  Atomic atomic;
  atomic.plane = plane;
  atomic.connector_crtc = property(panel_.connector, DRM_MODE_OBJECT_CONNECTOR, "CRTC_ID");
  atomic.crtc_mode = property(panel_.crtc, DRM_MODE_OBJECT_CRTC, "MODE_ID");
  atomic.crtc_active = property(panel_.crtc, DRM_MODE_OBJECT_CRTC, "ACTIVE");
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
  all = all && ::drmModeCreatePropertyBlob(card(), &panel_.mode, sizeof panel_.mode, &atomic.mode_blob) == 0;
  flip_request_.reset(::drmModeAtomicAlloc());
  if (!all || !flip_request_) return false;
  atomic_ = atomic;
  return true;
}

Status Output::acquire(std::uint32_t plane) {
  if (::drmSetMaster(card()) != 0 && errno != EINVAL) return panel_failed("can't take the display", errno);
  static_cast<void>(::drmSetClientCap(card(), DRM_CLIENT_CAP_UNIVERSAL_PLANES, 1));
  const std::uint32_t found = find_plane(plane);
  if (found == 0 && plane != 0) {
    return fail(ErrorCode::kBadSetting, "the panel: its controller has no plane %u, see modetest", plane);
  }
  if (found == 0 || !prepare_atomic(found)) atomic_.reset();
  former_.reset(::drmModeGetCrtc(card(), panel_.crtc));
  return {};
}

int Output::set_mode(std::uint32_t frame) {
  if (!atomic_) {
    auto connector = panel_.connector;
    auto mode = panel_.mode;
    return ::drmModeSetCrtc(card(), panel_.crtc, frame, 0, 0, &connector, 1, &mode) == 0 ? 0 : -errno;
  }
  const Request request(::drmModeAtomicAlloc());
  const auto add = [&](std::uint32_t object, std::uint32_t name, std::uint64_t number) {
    return ::drmModeAtomicAddProperty(request.get(), object, name, number) >= 0;
  };
  const auto& a = *atomic_;
  const std::array<std::uint64_t, 4> size = {0, 0, panel_.mode.hdisplay, panel_.mode.vdisplay};
  bool added = request && add(panel_.connector, a.connector_crtc, panel_.crtc) &&
               add(panel_.crtc, a.crtc_mode, a.mode_blob) && add(panel_.crtc, a.crtc_active, 1) &&
               add(a.plane, a.plane_frame, frame) && add(a.plane, a.plane_crtc, panel_.crtc);
  for (std::size_t i = 0; i < 4; ++i) {
    added = added && add(a.plane, a.source[i], size[i] << 16U) && add(a.plane, a.target[i], size[i]);
  }
  if (!added) return -ENOMEM;
  return ::drmModeAtomicCommit(card(), request.get(), DRM_MODE_ATOMIC_ALLOW_MODESET, nullptr);
}

int Output::request_flip(std::uint32_t frame, void* user) {
  if (!atomic_) {
    return ::drmModePageFlip(card(), panel_.crtc, frame, DRM_MODE_PAGE_FLIP_EVENT, user) == 0 ? 0 : -errno;
  }
  ::drmModeAtomicSetCursor(flip_request_.get(), 0);
  if (::drmModeAtomicAddProperty(flip_request_.get(), atomic_->plane, atomic_->plane_frame, frame) < 0) return -ENOMEM;
  return ::drmModeAtomicCommit(card(), flip_request_.get(), DRM_MODE_ATOMIC_NONBLOCK | DRM_MODE_PAGE_FLIP_EVENT, user);
}

Output::~Output() {
  if (former_ && former_->mode_valid != 0 && former_->buffer_id != 0) {
    auto connector = panel_.connector;
    static_cast<void>(::drmModeSetCrtc(card(), panel_.crtc, former_->buffer_id, former_->x, former_->y, &connector, 1,
                                       &former_->mode));
  }
  if (atomic_) static_cast<void>(::drmModeDestroyPropertyBlob(card(), atomic_->mode_blob));
}

}  // namespace plumbline::inline hal::inline linux_board::kms
