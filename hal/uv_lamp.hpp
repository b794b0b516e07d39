#pragma once
/// The lamp that cures the resin. It lights for a bounded time; there is no plain "on".

#include <chrono>
#include <cstdint>
#include <utility>

#include "hal/clock.hpp"
#include "hal/interlock.hpp"
#include "hal/units.hpp"
#include "slicer/core/error.hpp"

namespace plumbline::inline hal {

class UvLamp;

/// Why the lamp went off.
enum class ExposureEnd : std::uint8_t {
  kTimeUp,       ///< the requested time was over
  kStopped,      ///< Exposure::finish() or UvLamp::turn_off() ended it early
  kCoverOpened,  ///< opening the cover ended it early
};

/// Where a dose comes from.
enum class DoseSource : std::uint8_t {
  kMeasured,  ///< the lamp's monitor: a photodiode or the lamp's current
  kComputed,  ///< lit time * the board file's irradiance, on a board without a monitor
};

/// The result of an exposure.
struct ExposureReport {
  TimePoint began_at;
  nanoseconds asked{};
  nanoseconds lit{};  ///< how long the lamp's line was on; asked - lit is still to be cured
  ExposureEnd end = ExposureEnd::kTimeUp;
  Dose dose;  ///< at the film
  DoseSource source = DoseSource::kComputed;
};

/// A lit lamp. It goes off by itself at ends_by(), and when this object is destroyed. Move-only.
class [[nodiscard]] Exposure {
 public:
  Exposure(Exposure&& other) noexcept
      : lamp_(std::exchange(other.lamp_, nullptr)), began_at_(other.began_at_), asked_(other.asked_) {}
  Exposure& operator=(Exposure&&) = delete;
  Exposure(const Exposure&) = delete;
  Exposure& operator=(const Exposure&) = delete;
  ~Exposure();

  TimePoint began_at() const { return began_at_; }
  TimePoint ends_by() const { return began_at_ + asked_; }
  /// Whether the lamp's line is off again.
  bool over() const;

  /// Ends the exposure if it is not over, and checks whether the lamp obeyed. Call it once.
  /// @retval ErrorCode::kLampStuckOn  light although the line is off: the user must pull the plug
  /// @retval ErrorCode::kLampDead     no light although the line was on
  /// @retval ErrorCode::kPowerLost
  [[nodiscard]] Expected<ExposureReport> finish();

 private:
  friend class UvLamp;
  Exposure(UvLamp& lamp, TimePoint began_at, nanoseconds asked) : lamp_(&lamp), began_at_(began_at), asked_(asked) {}

  UvLamp* lamp_ = nullptr;
  TimePoint began_at_;
  nanoseconds asked_;
};

/// The lamp. Every back end guarantees the following, even if the firmware hangs or dies:
/// - off is armed before on: something else (a keeper process, a timer) holds the deadline before the line goes on
/// - off within 1 ms of the deadline
/// - off within 10 ms of the cover's opening
/// - off within 50 ms of the firmware's end or of the moment at which the system stops it, however that happens
class UvLamp {
 public:
  struct Limits {
    nanoseconds longest_exposure{};  ///< above 0
    Irradiance irradiance;           ///< at the film, from the board file
    /// Most light in any 60 s. A board's keeper refuses more; plan_print() does not ask for more.
    nanoseconds per_minute = std::chrono::seconds(60);
  };

  UvLamp(const UvLamp&) = delete;
  UvLamp& operator=(const UvLamp&) = delete;
  virtual ~UvLamp() = default;

  const Limits& limits() const { return limits_; }

  /// Lights the lamp for `cure` and returns at once, so that the next mask can be drawn meanwhile.
  /// @param cure  above 0, at most limits().longest_exposure
  /// @retval ErrorCode::kExposureTooLong   above a limit; nothing was lit
  /// @retval ErrorCode::kBadSetting        0 or less; nothing was lit
  /// @retval ErrorCode::kBusy              it is already lit
  /// @retval ErrorCode::kMaskNotPresented  the panel is blank or its last mask is not settled; nothing was lit
  /// @retval ErrorCode::kCoverOpen         nothing was lit
  /// @retval ErrorCode::kStageMoving       nothing was lit
  /// @retval ErrorCode::kLampFailed        off could not be armed; nothing was lit
  /// @retval ErrorCode::kPowerLost
  [[nodiscard]] Expected<Exposure> begin_exposure(nanoseconds cure);

  /// Calls begin_exposure(), sleeps until the end and calls Exposure::finish(), with the errors of both. Only the cover can end the
  /// light early.
  [[nodiscard]] Expected<ExposureReport> expose(nanoseconds cure);

  /// Turns the lamp off now. Always allowed, also if it is off.
  void turn_off() noexcept { do_turn_off(); }

  /// Whether there is light: measured by the lamp's monitor, or on a board without one, the state of its line.
  bool lit() const { return do_lit(); }

 protected:
  UvLamp(const Limits& limits, Interlock& interlock, Clock& clock)
      : limits_(limits), interlock_(interlock), clock_(clock) {
    interlock.add(*this);
  }

 private:
  friend class Exposure;

  /// Arms off, then turns the line on for `cure`.
  /// @returns when the line went on
  virtual Expected<TimePoint> do_begin(nanoseconds cure) = 0;
  /// Whether the line is off.
  virtual bool do_over() const = 0;
  virtual void do_turn_off() noexcept = 0;
  virtual bool do_lit() const = 0;
  /// Called once for each finished exposure, with the line off. The caller fills in `asked`.
  virtual Expected<ExposureReport> do_report() = 0;

  Limits limits_;
  Interlock& interlock_;
  Clock& clock_;
};

}  // namespace plumbline::inline hal
