#pragma once
/// A status screen's panel on a connector of a display controller: one buffer that is written and then sent.

#include <cstddef>
#include <cstdint>
#include <memory>
#include <optional>
#include <span>

#include "hal/linux/display/kms_panel.hpp"
#include "hal/wiring.hpp"
#include "slicer/core/error.hpp"

namespace plumbline::inline hal::inline linux_board {

class KmsScreen {
 public:
  /// Takes the connector and shows black.
  /// @param width, height  of the mode, pixels
  /// @param beside         the mask panel's card: one program can open a card's displays only through one descriptor
  /// @retval the errors of KmsPanel::open()
  [[nodiscard]] static Expected<KmsScreen> open(const ScreenSettings& settings, std::uint32_t width,
                                                std::uint32_t height, const std::optional<CardInUse>& beside);
  /// Finds the same display without taking it.
  [[nodiscard]] static Expected<DisplayFinding> examine(const ScreenSettings& settings, std::uint32_t width,
                                                        std::uint32_t height);
  KmsScreen(KmsScreen&&) noexcept;
  KmsScreen& operator=(KmsScreen&&) = delete;
  /// Restores what the panel showed before.
  ~KmsScreen();

  std::span<std::byte> memory() const;
  std::size_t pitch() const;  ///< bytes a row
  /// Sends what was written. Waits while a panel with memory of its own, such as one on SPI, receives it.
  /// @retval ErrorCode::kPanelFailed  the driver refused
  [[nodiscard]] Status send();

 private:
  class Device;
  explicit KmsScreen(std::unique_ptr<Device> device);
  std::unique_ptr<Device> device_;
};

}  // namespace plumbline::inline hal::inline linux_board
