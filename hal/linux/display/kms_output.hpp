#pragma once
/// Sets a panel's video mode and flips its frames.

#include <array>
#include <cstdint>
#include <optional>

#include "hal/linux/display/kms_search.hpp"
#include "slicer/core/error.hpp"

namespace plumbline::inline hal::inline linux_board::kms {

/// Uses atomic requests if the driver has them, else the older calls. The destructor restores what the panel showed before.
class Output {
 public:
  /// @param panel  must outlive it
  explicit Output(const FoundPanel& panel) : panel_(panel) {}
  Output(const Output&) = delete;
  Output& operator=(const Output&) = delete;
  ~Output();

  /// Takes over the display. Call once, before the others.
  /// @param plane  0: the primary one
  /// @retval ErrorCode::kBadSetting   the controller has no such plane
  /// @retval ErrorCode::kPanelFailed  another program has the display: the reason
  [[nodiscard]] Status acquire(std::uint32_t plane);
  /// Sets the mode and shows a frame. @returns 0 or a negative errno
  int set_mode(std::uint32_t frame);
  /// Requests a flip to a frame. When it happens the card sends an event with `user`. @returns 0 or a negative errno
  int request_flip(std::uint32_t frame, void* user);

 private:
  /// Numbers of the objects and properties in an atomic request.
  struct Atomic {
    std::uint32_t plane = 0;
    std::uint32_t mode_blob = 0;
    std::uint32_t connector_crtc = 0, crtc_mode = 0, crtc_active = 0;
    std::uint32_t plane_frame = 0, plane_crtc = 0;
    std::array<std::uint32_t, 4> source{};
    std::array<std::uint32_t, 4> target{};
  };

  bool prepare_atomic(std::uint32_t plane);
  std::uint32_t find_plane(std::uint32_t wanted) const;
  std::uint32_t property(std::uint32_t object, std::uint32_t type, const char* name) const;
  std::optional<std::uint64_t> value(std::uint32_t object, std::uint32_t type, const char* name) const;
  int card() const { return panel_.card.get(); }

  const FoundPanel& panel_;
  std::optional<Atomic> atomic_;
  Request flip_request_;  // made once, because making it allocates
  Crtc former_;
};

}  // namespace plumbline::inline hal::inline linux_board::kms
