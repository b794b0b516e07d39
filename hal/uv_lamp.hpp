#pragma once
/// The lamp that cures the resin. It is asked for bounded times and never simply switched on.

#include <chrono>
#include <cstdint>
#include <utility>

#include "hal/clock.hpp"
#include "hal/interlock.hpp"
#include "hal/units.hpp"
#include "slicer/core/error.hpp"

namespace plumbline {

class UvLamp;

/// Why the lamp went dark.
enum class ExposureEnd : std::uint8_t {
  kTimeUp,       ///< the time asked for was over
  kStopped,      ///< Exposure::finish() or UvLamp::darken() came before that
  kCoverOpened,  ///< the interlock cut it
};

/// Where a dose comes from.
enum class DoseSource : std::uint8_t {
  kMeasured,  ///< the lamp's monitor: a photodiode, or its current
  kComputed,  ///< lit time times the board file's irradiance, on a board without a monitor
};

/// What an exposure has been.
struct ExposureReport {
  TimePoint began_at;
  nanoseconds asked{};
  nanoseconds lit{};  ///< time that the lamp's line was on. asked - lit is what is still to be cured
  ExposureEnd end = ExposureEnd::kTimeUp;
  Dose dose;  ///< at the film
  DoseSource source = DoseSource::kComputed;
};

/// A lamp that is lit. It goes dark by itself at ends_by(), and when this object ends. Move-only.
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
  /// The lamp's line is off again.
  bool over() const;

  /// Ends the exposure, now where it is not over yet, and looks whether the lamp did as it was told. The object is spent.
  /// @retval ErrorCode::kLampStuckOn  there is light, although the line is off. The user pulls the plug
  /// @retval ErrorCode::kLampDead     there was no light, although the line was on
  /// @retval ErrorCode::kPowerLost
  [[nodiscard]] Expected<ExposureReport> finish();

 private:
  friend class UvLamp;
  Exposure(UvLamp& lamp, TimePoint began_at, nanoseconds asked) : lamp_(&lamp), began_at_(began_at), asked_(asked) {}

  UvLamp* lamp_ = nullptr;
  TimePoint began_at_;
  nanoseconds asked_;
};

/// The lamp. Every back end holds to these, whatever the firmware is doing or has ceased to do:
/// - off is armed before on: the deadline stands with somebody else (a keeper process, a timer) before the line goes on
/// - dark by the deadline, within 1 ms
/// - dark within 10 ms of the cover's opening
/// - dark within 50 ms of the firmware's end, however it ends
class UvLamp {
 public:
  struct Limits {
    nanoseconds longest_exposure{};  ///< of one exposure; above 0
    Irradiance irradiance;           ///< at the film, as the board file has it
  };

  UvLamp(const UvLamp&) = delete;
  UvLamp& operator=(const UvLamp&) = delete;
  virtual ~UvLamp() = default;

  const Limits& limits() const { return limits_; }

  /// Lights the lamp for `cure` and returns at once, so that the next mask can be made meanwhile.
  /// @param cure  above 0, at most limits().longest_exposure
  /// @retval ErrorCode::kExposureTooLong   above the limit; nothing was lit
  /// @retval ErrorCode::kBadSetting        0 or less; nothing was lit
  /// @retval ErrorCode::kBusy              it is lit already
  /// @retval ErrorCode::kMaskNotPresented  the panel is blank or its last mask has not been scanned out; nothing was lit
  /// @retval ErrorCode::kCoverOpen         nothing was lit
  /// @retval ErrorCode::kStageMoving       nothing was lit
  /// @retval ErrorCode::kLampFailed        off could not be armed, so on was not tried
  /// @retval ErrorCode::kPowerLost
  [[nodiscard]] Expected<Exposure> begin_exposure(nanoseconds cure);

  /// begin_exposure(), a wait that nothing but the cover interrupts, and Exposure::finish().
  /// @retval the errors of both
  [[nodiscard]] Expected<ExposureReport> expose(nanoseconds cure);

  /// Off, now. Always allowed, any number of times.
  void darken() noexcept { do_darken(); }

  /// There is light: from the lamp's monitor, on a board without one the line read back.
  bool lit() const { return do_lit(); }

 protected:
  UvLamp(const Limits& limits, Interlock& interlock, Clock& clock)
      : limits_(limits), interlock_(interlock), clock_(clock) {
    interlock.enter(*this);
  }

 private:
  friend class Exposure;

  /// Arms off for `cure` after the moment of on, then turns on.
  /// @returns that moment
  virtual Expected<TimePoint> do_begin(nanoseconds cure) = 0;
  /// The line is off.
  virtual bool do_over() const = 0;
  virtual void do_darken() noexcept = 0;
  virtual bool do_lit() const = 0;
  /// Called with the line off, once for each do_begin() whose exposure is finished. `asked` need not be filled in.
  virtual Expected<ExposureReport> do_report() = 0;

  Limits limits_;
  Interlock& interlock_;
  Clock& clock_;
};

}  // namespace plumbline
