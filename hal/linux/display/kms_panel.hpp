#pragma once
/// A panel on a connector of a display controller, through the kernel's mode setting. Only the kms_* files know libdrm.

#include <array>
#include <chrono>
#include <cstdint>
#include <memory>
#include <span>
#include <string>

#include "hal/wiring.hpp"
#include "slicer/core/error.hpp"

namespace plumbline::inline hal::inline linux_board {

/// The display found, for people.
struct DisplayFinding {
  std::string card;  ///< "/dev/dri/card0, driver vc4"
  std::string mode;  ///< "480x2560 at 60 Hz"
  bool atomic = false;
};

/// A card whose display is in use.
struct CardInUse {
  int descriptor = -1;     ///< of its owner, open as long as the owner lives
  std::string path;        ///< "/dev/dri/card0"
  std::uint32_t crtc = 0;  ///< object number of the controller in use
};

/// Two buffers of XRGB8888: one is scanned out, the other can be written. Move-only.
class KmsPanel {
 public:
  /// Takes the display and its console, and shows black.
  /// @param width, height  of the mode, pixels
  /// @retval ErrorCode::kBadSetting   no such card, connector, mode or plane; the message lists those available
  /// @retval ErrorCode::kPanelFailed  nothing is connected, another program has the display, or the driver refused
  [[nodiscard]] static Expected<KmsPanel> open(const DisplaySettings& settings, std::uint32_t width,
                                               std::uint32_t height);
  /// Finds the same display without taking it.
  [[nodiscard]] static Expected<DisplayFinding> examine(const DisplaySettings& settings, std::uint32_t width,
                                                        std::uint32_t height);
  KmsPanel(KmsPanel&&) noexcept;
  KmsPanel& operator=(KmsPanel&&) = delete;
  KmsPanel(const KmsPanel&) = delete;
  KmsPanel& operator=(const KmsPanel&) = delete;
  /// Restores the console.
  ~KmsPanel();

  /// The buffer that is neither scanned out nor about to be.
  /// @retval ErrorCode::kFlipTimeout  a flip that timed out has still not happened, so both buffers may be in use
  [[nodiscard]] Expected<std::span<std::uint32_t>> back();
  std::size_t pitch() const;  ///< words a row

  /// Shows the back buffer from the next frame's first row on. Returns after the flip; the last row is shown one frame() later.
  /// @retval ErrorCode::kFlipTimeout  the flip took too long
  /// @retval ErrorCode::kPanelFailed  the driver refused
  [[nodiscard]] Status flip();

  std::chrono::nanoseconds frame() const;  ///< time to scan out one frame
  CardInUse card() const;                  ///< valid as long as this

 private:
  class Device;
  explicit KmsPanel(std::unique_ptr<Device> device);
  std::unique_ptr<Device> device_;
};

}  // namespace plumbline::inline hal::inline linux_board
