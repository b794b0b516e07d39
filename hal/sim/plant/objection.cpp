#include "hal/sim/plant/objection.hpp"

#include <array>
#include <cstdio>

namespace plumbline::inline hal::inline sim {

ObjectionKind kind_of(LossKind kind) {
  switch (kind) {
    case LossKind::kDropped: return ObjectionKind::kDropped;
    case LossKind::kTorn: return ObjectionKind::kTorn;
    case LossKind::kShadowed: break;
  }
  return ObjectionKind::kShadowed;
}

std::string_view to_string(ObjectionKind kind) {
  switch (kind) {
    case ObjectionKind::kMaskChangedUnderLight: return "mask changed under light";
    case ObjectionKind::kMaskTornUnderLight: return "mask torn under light";
    case ObjectionKind::kMotionUnderLight: return "motion under light";
    case ObjectionKind::kLightWithCoverOpen: return "light with the cover open";
    case ObjectionKind::kExposureWithoutMask: return "exposure without a mask";
    case ObjectionKind::kTravelPastEnd: return "travel past an end";
    case ObjectionKind::kLiftSkipped: return "lift skipped";
    case ObjectionKind::kDoseOff: return "dose off";
    case ObjectionKind::kNotBonded: return "layer not bonded";
    case ObjectionKind::kDropped: return "region dropped";
    case ObjectionKind::kTorn: return "piece torn off";
    case ObjectionKind::kShadowed: return "light blocked by what lies on the film";
  }
  return "unknown objection";
}

std::string to_string(const Objection& objection) {
  const std::chrono::duration<double> at = objection.at.time_since_epoch();
  std::array<char, 96> place{};
  std::snprintf(place.data(), place.size(), "%.3f s, layer %u, %.3f mm: ", at.count(), objection.layer,
                objection.z.above_film().millimetres());
  std::string text = place.data();
  text += to_string(objection.kind);
  if (!objection.detail.empty()) text += ": " + objection.detail;
  if (objection.loss) text += ": " + to_string(*objection.loss);
  return text;
}

}  // namespace plumbline::inline hal::inline sim
