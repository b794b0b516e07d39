#pragma once
/// A panel on a connector of a display controller, through the kernel's mode setting. kms_panel.cpp and kms_search.* know libdrm.

#include <array>
#include <chrono>
#include <cstdint>
#include <memory>
#include <span>
#include <string>

#include "slicer/core/error.hpp"

namespace plumbline {

/// Where the panel is: as the board file has it.
struct DisplaySettings {
  std::string card;              ///< "/dev/dri/card0"; empty: the first one that has the connector
  std::string connector;         ///< "DSI-1", "HDMI-A-1", ...
  std::uint32_t refresh_hz = 0;  ///< of the mode; 0: any that has the panel's size
  std::uint32_t plane = 0;       ///< object number, as modetest shows; 0: the controller's primary one
  std::chrono::nanoseconds flip_timeout = std::chrono::milliseconds(500);  ///< the longest that a flip may take
};

/// What a look at the display found; for people.
struct DisplayFinding {
  std::string card;  ///< "/dev/dri/card0, driver vc4"
  std::string mode;  ///< "480x2560 at 60 Hz"
  bool atomic = false;
};

/// Two buffers of XRGB8888, mapped for good: one is scanned out, the other can be written. Move-only.
class KmsPanel {
 public:
  /// Takes the display and its console, and shows black.
  /// @param width, height  of the mode
  /// @retval ErrorCode::kBadSetting   no such card, connector, mode or plane: what there is
  /// @retval ErrorCode::kPanelFailed  nothing is connected, another program has the display, or it refused: the reason
  [[nodiscard]] static Expected<KmsPanel> open(const DisplaySettings& settings, std::uint32_t width,
                                               std::uint32_t height);
  /// The same without taking anything.
  [[nodiscard]] static Expected<DisplayFinding> look(const DisplaySettings& settings, std::uint32_t width,
                                                     std::uint32_t height);
  KmsPanel(KmsPanel&&) noexcept;
  KmsPanel& operator=(KmsPanel&&) = delete;
  KmsPanel(const KmsPanel&) = delete;
  KmsPanel& operator=(const KmsPanel&) = delete;
  /// The console is as it was.
  ~KmsPanel();

  /// The buffer that is not scanned out, nor about to be.
  /// @retval ErrorCode::kFlipTimeout  a flip that was given up has still not happened: both buffers may be in use
  [[nodiscard]] Expected<std::span<std::uint32_t>> back();
  std::size_t pitch() const;  ///< words a row

  /// Shows the back buffer, from a frame's first row on. Returns after the flip; its last row is out a frame() later.
  /// @retval ErrorCode::kFlipTimeout  the flip was not done in time
  /// @retval ErrorCode::kPanelFailed  the display refused
  [[nodiscard]] Status flip();

  std::chrono::nanoseconds frame() const;  ///< time to scan one out

 private:
  class Device;
  explicit KmsPanel(std::unique_ptr<Device> device);
  std::unique_ptr<Device> device_;
};

}  // namespace plumbline
