#pragma once
/// What the user sees, hears and touches: cover, lights, buzzer. Buttons and the cover's switch are events (hal/events.hpp).

#include <chrono>
#include <cstdint>

#include "hal/clock.hpp"
#include "hal/interlock.hpp"
#include "slicer/core/error.hpp"

namespace plumbline {

enum class PanelLight : std::uint8_t {
  kReady,      ///< takes a job
  kPrinting,   ///<
  kAttention,  ///< something waits for the user
  kFault,      ///<
};
inline constexpr std::size_t kPanelLightCount = 4;

enum class LightState : std::uint8_t { kOff, kOn, kBlinking };

class FrontPanel {
 public:
  static constexpr nanoseconds kLongestBeep = std::chrono::seconds(5);

  FrontPanel(const FrontPanel&) = delete;
  FrontPanel& operator=(const FrontPanel&) = delete;
  virtual ~FrontPanel() = default;

  /// As the switch is now. A switch that can't be read counts as open.
  bool cover_open() const { return do_cover_open(); }

  /// @retval ErrorCode::kPowerLost
  [[nodiscard]] Status set_light(PanelLight light, LightState state);

  /// Starts a beep and returns at once; a longer time than kLongestBeep is cut to it. A new beep ends the last one.
  /// @retval ErrorCode::kPowerLost
  [[nodiscard]] Status beep(nanoseconds time);

 protected:
  explicit FrontPanel(Interlock& interlock) : interlock_(interlock) { interlock.enter(*this); }

 private:
  virtual bool do_cover_open() const = 0;
  virtual Status do_set_light(PanelLight light, LightState state) = 0;
  virtual Status do_beep(nanoseconds time) = 0;

  Interlock& interlock_;
};

}  // namespace plumbline
