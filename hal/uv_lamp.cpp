#include "hal/uv_lamp.hpp"

#include <cassert>

namespace plumbline::inline hal {
namespace {

double seconds(nanoseconds time) { return std::chrono::duration<double>(time).count(); }

}  // namespace

Exposure::~Exposure() {
  if (lamp_ != nullptr) lamp_->turn_off();
}

bool Exposure::over() const {
  assert(lamp_ != nullptr && "finish() was already called");
  return lamp_->do_over();
}

Expected<ExposureReport> Exposure::finish() {
  assert(lamp_ != nullptr && "finish() was already called");
  UvLamp& lamp = *std::exchange(lamp_, nullptr);
  if (!lamp.do_over()) lamp.turn_off();
  PLUMBLINE_TRY(lamp.interlock_.check_power());
  auto report = lamp.do_report();
  if (report) report->asked = asked_;
  return report;
}

Expected<Exposure> UvLamp::begin_exposure(nanoseconds cure) {
  PLUMBLINE_TRY(interlock_.check_power());
  if (cure <= nanoseconds::zero())
    return fail(ErrorCode::kBadSetting, "an exposure of %g s: it must be longer than 0", seconds(cure));
  if (cure > limits_.longest_exposure) {
    return fail(ErrorCode::kExposureTooLong, "an exposure of %g s: the board file allows at most %g s", seconds(cure),
                seconds(limits_.longest_exposure));
  }
  if (lit()) return fail(ErrorCode::kBusy, "the lamp is already lit");
  if (interlock_.cover_open())
    return fail(ErrorCode::kCoverOpen, "the lamp stays off while the cover is open:\tclose it");
  if (interlock_.stage_moving()) return fail(ErrorCode::kStageMoving, "the lamp stays off while the stage moves");
  if (!interlock_.mask_presented()) {
    return fail(ErrorCode::kMaskNotPresented, "the lamp stays off because no mask is on the panel");
  }
  auto began_at = do_begin(cure);
  if (!began_at) return tl::unexpected<Error>(began_at.error());
  return Exposure(*this, *began_at, cure);
}

Expected<ExposureReport> UvLamp::expose(nanoseconds cure) {
  auto exposure = begin_exposure(cure);
  if (!exposure) return tl::unexpected<Error>(exposure.error());
  PLUMBLINE_TRY(clock_.sleep_until(exposure->ends_by()));
  return exposure->finish();
}

}  // namespace plumbline::inline hal
