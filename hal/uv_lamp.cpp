#include "hal/uv_lamp.hpp"

#include <cassert>

namespace plumbline {
namespace {

double seconds(nanoseconds time) { return std::chrono::duration<double>(time).count(); }

}  // namespace

Exposure::~Exposure() {
  if (lamp_ != nullptr) lamp_->darken();
}

bool Exposure::over() const {
  assert(lamp_ != nullptr && "this exposure is finished");
  return lamp_->do_over();
}

Expected<ExposureReport> Exposure::finish() {
  assert(lamp_ != nullptr && "this exposure is finished");
  UvLamp& lamp = *std::exchange(lamp_, nullptr);
  if (!lamp.do_over()) lamp.darken();
  PLUMBLINE_TRY(lamp.interlock_.power());
  auto report = lamp.do_report();
  if (report) report->asked = asked_;
  return report;
}

Expected<Exposure> UvLamp::begin_exposure(nanoseconds cure) {
  PLUMBLINE_TRY(interlock_.power());
  if (cure <= nanoseconds::zero())
    return fail(ErrorCode::kBadSetting, "an exposure of %g s: more than 0 is needed", seconds(cure));
  if (cure > limits_.longest_exposure) {
    return fail(ErrorCode::kExposureTooLong, "an exposure of %g s: this lamp is never lit for more than %g s at a time",
                seconds(cure), seconds(limits_.longest_exposure));
  }
  if (lit()) return fail(ErrorCode::kBusy, "the lamp is lit already");
  if (interlock_.cover_open())
    return fail(ErrorCode::kCoverOpen, "the lamp stays dark while the cover is open: close it");
  if (interlock_.stage_moving()) return fail(ErrorCode::kStageMoving, "the lamp stays dark while the stage moves");
  if (!interlock_.mask_presented()) {
    return fail(ErrorCode::kMaskNotPresented, "the lamp stays dark because no mask is on the panel");
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

}  // namespace plumbline
