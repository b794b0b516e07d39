#pragma once
/// The user's side of the machine: cover, lights, buzzer. Buttons and cover changes arrive as events (hal/events.hpp).

#include <chrono>
#include <cstdint>

#include "hal/clock.hpp"
#include "hal/interlock.hpp"
#include "slicer/core/error.hpp"

namespace plumbline::inline hal {

enum class PanelLight : std::uint8_t {
  kReady,      ///< ready for a job
  kPrinting,   ///<
  kAttention,  ///< waiting for the user
  kFault,      ///<
};
inline constexpr std::size_t kPanelLightCount = 4;

enum class LightState : std::uint8_t { kOff, kOn, kBlinking };

class FrontPanel {
 public:
  /// A longer beep would only annoy; no caller needs one.
  static constexpr nanoseconds kLongestBeep = std::chrono::seconds(5);

  FrontPanel(const FrontPanel&) = delete;
  FrontPanel& operator=(const FrontPanel&) = delete;
  virtual ~FrontPanel() = default;

  /// The switch's present state. A switch that can't be read counts as open.
  bool cover_open() const { return do_cover_open(); }

  /// @retval ErrorCode::kPowerLost
  [[nodiscard]] Status set_light(PanelLight light, LightState state);

  /// Starts a beep of `time`, at most kLongestBeep, and returns at once. It replaces a beep that is still sounding.
  /// @retval ErrorCode::kPowerLost
  [[nodiscard]] Status beep(nanoseconds time);

 protected:
  explicit FrontPanel(Interlock& interlock) : interlock_(interlock) { interlock.add(*this); }

 private:
  virtual bool do_cover_open() const = 0;
  virtual Status do_set_light(PanelLight light, LightState state) = 0;
  virtual Status do_beep(nanoseconds time) = 0;

  Interlock& interlock_;
};

}  // namespace plumbline::inline hal
