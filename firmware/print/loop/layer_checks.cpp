#include "firmware/print/loop/layer_checks.hpp"

#include <algorithm>
#include <chrono>
#include <cmath>

#include "firmware/messages/printer_code.hpp"

namespace plumbline::firmware {
namespace {

/// Measured doses that are off by more, as a share, end the print. A trade-off: resins forgive about as much.
constexpr double kDoseFault = 0.05;
/// How far within their limits resin and board must be before a print goes on that waits for them. A trade-off: a wider margin waits
/// longer, a narrower one lets a sensor's noise stop the print again.
constexpr double kResinHysteresis = 0.5;
constexpr Celsius kBoardHysteresis(5);

}  // namespace

Expected<Temperatures> read_temperatures(const Thermals& thermals) {
  Temperatures found;
  for (std::size_t i = 0; i < found.size(); ++i) {
    const auto read = thermals.temperature(static_cast<TemperatureSite>(i));
    PLUMBLINE_TRY(read);
    found[i] = *read;
  }
  return found;
}

LayerFinding check_temperatures(const Temperatures& found, const PrintSettings& settings, bool waits) {
  const Celsius lamp = found[static_cast<std::size_t>(TemperatureSite::kLamp)];
  const Celsius resin = found[static_cast<std::size_t>(TemperatureSite::kResin)];
  const Celsius board = found[static_cast<std::size_t>(TemperatureSite::kBoard)];
  // A narrow range has a middle all the same.
  const double span = settings.resin_max.value() - settings.resin_min.value();
  const Celsius inside(waits ? std::min(kResinHysteresis, span / 4) : 0);
  LayerFinding finding;
  if (waits ? lamp >= settings.lamp_resume : lamp > settings.lamp_max) {
    finding.fault = FaultCode::kLampTooHot;
    finding.text.add("the lamp is at %.1f degrees C, %.0f allowed", lamp.value(), settings.lamp_max.value());
    finding.told = {PrinterCode::kWaitsForLamp,
                    {{PrinterFact::kLampC, lamp.value()}, {PrinterFact::kLampLimitC, settings.lamp_max.value()}}};
  } else if (resin < settings.resin_min + inside || resin > settings.resin_max - inside) {
    const bool is_cold = resin < settings.resin_min + inside;
    finding.fault = is_cold ? FaultCode::kResinTooCold : FaultCode::kResinTooWarm;
    finding.text.add("the resin is at %.1f degrees C, %.0f to %.0f allowed", resin.value(), settings.resin_min.value(),
                     settings.resin_max.value());
    finding.told = {PrinterCode::kWaitsForResin,
                    {{PrinterFact::kResinC, resin.value()},
                     {PrinterFact::kResinLeastC, settings.resin_min.value()},
                     {PrinterFact::kResinMostC, settings.resin_max.value()}}};
  } else if (waits ? board >= settings.board_max - kBoardHysteresis : board > settings.board_max) {
    finding.fault = FaultCode::kBoardTooHot;
    finding.text.add("the printer's board is at %.1f degrees C, %.0f allowed", board.value(),
                     settings.board_max.value());
    finding.told = {PrinterCode::kWaitsForBoard,
                    {{PrinterFact::kBoardC, board.value()}, {PrinterFact::kBoardLimitC, settings.board_max.value()}}};
  }
  return finding;
}

LayerFinding check_fans(const Thermals& thermals) {
  LayerFinding finding;
  if (thermals.fan_health(Fan::kLamp) == FanHealth::kStalled) {
    finding.fault = FaultCode::kFanStalled;
    finding.text.add("the lamp's fan is on and does not turn");
    finding.told = PrinterCode::kWaitsForLampFan;
  } else if (thermals.fan_health(Fan::kChamber) == FanHealth::kStalled) {
    finding.fault = FaultCode::kChamberFanStalled;
    finding.text.add("the chamber's fan is on and does not turn");
    finding.told = PrinterCode::kWaitsForChamberFan;
  }
  return finding;
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

}  // namespace plumbline::firmware
