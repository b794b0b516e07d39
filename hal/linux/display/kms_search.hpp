#pragma once
/// Finds the card, connector and mode of a panel. Only the kms_* files include libdrm.

#include <unistd.h>
#include <xf86drm.h>
#include <xf86drmMode.h>

#include <cstdint>
#include <memory>
#include <optional>
#include <string>
#include <utility>

#include "hal/linux/display/kms_panel.hpp"
#include "slicer/core/error.hpp"

namespace plumbline::inline hal::inline linux_board::kms {

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

/// Closes its descriptor.
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

/// A panel and its open card.
struct FoundPanel {
  File card{-1};
  std::string path;
  std::uint32_t connector = 0;  ///< object number
  drmModeModeInfo mode{};
  std::uint32_t crtc = 0;        ///< object number of the controller
  std::uint32_t crtc_index = 0;  ///< its place among the card's controllers
};

/// @param width, height  of the mode, pixels
/// @param beside         another display of this program: its card is not opened again, its controller not chosen
/// @retval ErrorCode::kBadSetting   no such connector or mode; the message lists those available
/// @retval ErrorCode::kPanelFailed  nothing is connected, or permission is missing
[[nodiscard]] Expected<FoundPanel> find_panel(const DisplaySettings& settings, std::uint32_t width,
                                              std::uint32_t height,
                                              const std::optional<CardInUse>& beside = std::nullopt);

/// "480x2560 at 60 Hz"
std::string mode_name(const drmModeModeInfo& mode);
/// "vc4"
std::string driver_of(int card);

/// "the panel WHAT: REASON", and what to do about it.
/// @param reason  an errno
tl::unexpected<Error> panel_failed(const char* what, int reason);

}  // namespace plumbline::inline hal::inline linux_board::kms
