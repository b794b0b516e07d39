#include "firmware/print/layer_checks.hpp"

#include <chrono>
#include <cmath>

namespace plumbline {
namespace {

/// Measured doses that are off by more, as a share, end the print. A trade-off: resins forgive about as much.
constexpr double kDoseFault = 0.05;

}  // namespace

FaultCode temperature_fault(Celsius lamp, Celsius resin, const PrintSettings& settings) {
  return lamp > settings.lamp_max     ? FaultCode::kLampTooHot
         : resin < settings.resin_min ? FaultCode::kResinTooCold
         : resin > settings.resin_max ? FaultCode::kResinTooWarm
                                      : FaultCode::kNone;
}

Expected<LayerFinding> check_temperatures(const Thermals& thermals, const PrintSettings& settings) {
  const auto lamp = thermals.temperature(TemperatureSite::kLamp);
  PLUMBLINE_TRY(lamp);
  const auto resin = thermals.temperature(TemperatureSite::kResin);
  PLUMBLINE_TRY(resin);
  LayerFinding found;
  if (thermals.fan_health(Fan::kLamp) == FanHealth::kStalled) {
    found.fault = FaultCode::kFanStalled;
    found.text.add("the lamp's fan is on and does not turn");
    return found;
  }
  found.fault = temperature_fault(*lamp, *resin, settings);
  if (found.fault == FaultCode::kNone || found.fault == FaultCode::kLampTooHot) return found;
  found.text.add("the resin is at %.1f degrees C, %.0f to %.0f allowed", resin->value(), settings.resin_min.value(),
                 settings.resin_max.value());
  return found;
}

double dose_error(const ExposureReport& exposure, Dose expected) { return std::abs(exposure.dose / expected - 1); }

LayerFinding check_dose(const ExposureReport& exposure, Dose expected, std::uint32_t layer) {
  LayerFinding found;
  if (dose_error(exposure, expected) <= kDoseFault) return found;
  found.fault = FaultCode::kDoseOff;
  found.text.add("layer %u got %.3g mJ/cm2 in %.2f s instead of %.3g mJ/cm2", layer + 1, exposure.dose.value(),
                 std::chrono::duration<double>(exposure.lit).count(), expected.value());
  return found;
}

}  // namespace plumbline
