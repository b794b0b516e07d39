#pragma once
/// Which card, connector and mode a panel has. With kms_panel.cpp this is what knows libdrm: nobody else includes it.

#include <unistd.h>
#include <xf86drm.h>
#include <xf86drmMode.h>

#include <cstdint>
#include <memory>
#include <string>
#include <utility>

#include "hal/linux/display/kms_panel.hpp"
#include "slicer/core/error.hpp"

namespace plumbline::kms {

template <auto Free>
struct Freed {
  template <class T>
  void operator()(T* pointer) const {
    Free(pointer);
  }
};
using Resources = std::unique_ptr<drmModeRes, Freed<drmModeFreeResources>>;
using Connector = std::unique_ptr<drmModeConnector, Freed<drmModeFreeConnector>>;
using Encoder = std::unique_ptr<drmModeEncoder, Freed<drmModeFreeEncoder>>;
using Crtc = std::unique_ptr<drmModeCrtc, Freed<drmModeFreeCrtc>>;
using Plane = std::unique_ptr<drmModePlane, Freed<drmModeFreePlane>>;
using Planes = std::unique_ptr<drmModePlaneRes, Freed<drmModeFreePlaneResources>>;
using Properties = std::unique_ptr<drmModeObjectProperties, Freed<drmModeFreeObjectProperties>>;
using Property = std::unique_ptr<drmModePropertyRes, Freed<drmModeFreeProperty>>;
using Request = std::unique_ptr<drmModeAtomicReq, Freed<drmModeAtomicFree>>;

/// A descriptor that is closed.
class File {
 public:
  explicit File(int file) : file_(file) {}
  File(File&& other) noexcept : file_(std::exchange(other.file_, -1)) {}
  File& operator=(File&& other) noexcept {
    std::swap(file_, other.file_);
    return *this;
  }
  ~File() {
    if (file_ >= 0) ::close(file_);
  }
  int get() const { return file_; }

 private:
  int file_;
};

/// What an open card has for the panel.
struct Found {
  File card{-1};
  std::string path;
  std::uint32_t connector = 0;
  drmModeModeInfo mode{};
  std::uint32_t crtc = 0;
  std::uint32_t crtc_index = 0;
};

/// @param width, height  of the mode
/// @retval ErrorCode::kBadSetting   no such connector or mode: what there is
/// @retval ErrorCode::kPanelFailed  nothing is connected, or no permission
[[nodiscard]] Expected<Found> find(const DisplaySettings& settings, std::uint32_t width, std::uint32_t height);

/// "480x2560 at 60 Hz"
std::string mode_name(const drmModeModeInfo& mode);
/// "vc4"
std::string driver_of(int card);

/// What failed, the system's reason, and what to do.
/// @param reason  an errno
tl::unexpected<Error> panel_failed(const char* what, int reason);

}  // namespace plumbline::kms
