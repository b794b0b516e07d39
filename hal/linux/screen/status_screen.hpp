#pragma once
/// The status screen of a board: DRM dumb buffers, and touch through evdev.

#include <condition_variable>
#include <memory>
#include <mutex>
#include <optional>
#include <thread>
#include <vector>

#include "hal/clock.hpp"
#include "hal/linux/display/kms_screen.hpp"
#include "hal/linux/screen/pack_screen.hpp"
#include "hal/linux/screen/touch_panel.hpp"
#include "hal/status_screen.hpp"
#include "hal/wiring.hpp"

namespace plumbline::inline hal::inline linux_board {

/// A thread of its own converts and sends frames: over SPI at 32 MHz the 150 kB of 320 x 240 pixels take 38 ms. A frame that comes while
/// one is sent replaces any other that waits.
class LinuxStatusScreen final : public StatusScreen {
 public:
  /// @param beside  the mask panel's card
  /// @param clock   for the times of touches; must outlive it
  /// @retval the errors of KmsScreen::open() and TouchPanel::open()
  [[nodiscard]] static Expected<std::unique_ptr<LinuxStatusScreen>> open(const ScreenSettings& settings,
                                                                         const std::optional<CardInUse>& beside,
                                                                         const Clock& clock);
  ~LinuxStatusScreen() override;

  static ScreenLayout layout_of(const ScreenSettings& settings);

 private:
  LinuxStatusScreen(const ScreenLayout& layout, KmsScreen panel, std::optional<TouchPanel> touch, const Clock& clock);
  Status do_present(std::span<const std::uint16_t> pixels) override;
  std::optional<ScreenTouch> do_next_touch() override;
  void run_thread();

  ScreenLayout layout_;
  KmsScreen panel_;
  std::optional<TouchPanel> touch_;
  const Clock& clock_;
  std::mutex mutex_;  ///< of the four below; held for a copy or a swap
  std::condition_variable changed_;
  std::vector<std::uint16_t> waiting_;
  bool has_waiting_ = false, ends_ = false;
  bool failed_ = false;                 ///< the last frame could not be sent
  std::vector<std::uint16_t> sending_;  ///< the thread's
  std::thread thread_;
};

}  // namespace plumbline::inline hal::inline linux_board
