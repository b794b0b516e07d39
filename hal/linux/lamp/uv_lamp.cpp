#include "hal/linux/lamp/uv_lamp.hpp"

#include "hal/linux/events/clock.hpp"

namespace plumbline::inline hal::inline linux_board {

Expected<TimePoint> LinuxUvLamp::do_begin(nanoseconds cure) {
  watch_.drain(monotonic_now());
  const auto keeper = watch_.keeper();
  PLUMBLINE_TRY(keeper);
  const auto lit = (*keeper)->light(cure);
  if (!lit) return tl::unexpected<Error>(lit.error());
  began_at_ = *lit;
  asked_ = cure;
  watch_.on_lit(*lit);
  return TimePoint(*lit);
}

bool LinuxUvLamp::do_over() const { return !do_lit(); }

bool LinuxUvLamp::do_lit() const {
  watch_.drain(monotonic_now());
  return watch_.lit();
}

void LinuxUvLamp::do_turn_off() noexcept {
  if (!do_lit()) return;
  // A keeper that does not reply is ended, and its line taken. Until that has worked the lamp counts as lit, which do_report() reports.
  if (const auto keeper = watch_.keeper()) static_cast<void>((*keeper)->turn_off());
  watch_.drain(monotonic_now());
}

Expected<ExposureReport> LinuxUvLamp::do_report() {
  if (do_lit()) {
    return fail(ErrorCode::kLampStuckOn, "the lamp's line could not be turned off:\tpull the plug of the printer");
  }
  if (const char* const reason = watch_.cut_by_loss()) {
    return fail(ErrorCode::kLampFailed,
                "the lamp's keeper %s during an exposure: the firmware turned the lamp off and started another keeper",
                reason);
  }
  constexpr nanoseconds kOnTime = std::chrono::milliseconds(1);  // UvLamp promises the deadline to within 1 ms
  ExposureReport report;
  report.began_at = TimePoint(began_at_);
  report.asked = asked_;
  report.lit = watch_.dark_at() - began_at_;
  report.source = DoseSource::kComputed;
  report.dose = dose_of(limits().irradiance, report.lit);
  if (watch_.cut_by_cover()) {
    report.end = ExposureEnd::kCoverOpened;
  } else if (report.lit + kOnTime < asked_) {
    report.end = ExposureEnd::kStopped;
  }
  return report;
}

}  // namespace plumbline::inline hal::inline linux_board
