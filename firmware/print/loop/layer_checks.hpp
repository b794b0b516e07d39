#pragma once
/// Checks for every layer: temperatures and fans before its light, the dose after it.

#include <array>

#include "firmware/io/text/fixed_text.hpp"
#include "firmware/print/loop/print_settings.hpp"
#include "firmware/print/status/fault.hpp"
#include "hal/thermals.hpp"
#include "hal/uv_lamp.hpp"
#include "slicer/core/error.hpp"
#include "slicer/core/words/told.hpp"

namespace plumbline::firmware {

struct LayerFinding {
  FaultCode fault = FaultCode::kNone;  ///< kNone: all is well
  FixedText<160> text;
  Told told;
};

/// By TemperatureSite.
using Temperatures = std::array<Celsius, kTemperatureSiteCount>;

/// @retval ErrorCode::kSensorDead, kPowerLost
[[nodiscard]] Expected<Temperatures> read_temperatures(const Thermals& thermals);

/// Whether a print may go on at these temperatures.
/// @param waits  it already waits for them: so that it does not go on and off, they must be well within their limits
/// @returns kLampTooHot, kResinTooCold, kResinTooWarm, kBoardTooHot, or kNone. None of them need end a print: it can wait
LayerFinding check_temperatures(const Temperatures& found, const PrintSettings& settings, bool waits);

/// Whether all fans turn that should.
/// @returns kFanStalled, kChamberFanStalled, or kNone
LayerFinding check_fans(const Thermals& thermals);

/// How far a measured dose is off, as a share of the expected one.
double dose_error(const ExposureReport& exposure, Dose expected);
/// Doses that are off by more are counted for the report.
inline constexpr double kDoseNoted = 0.01;

/// @param layer  from 0
/// @returns kDoseOff or kNone
LayerFinding check_dose(const ExposureReport& exposure, Dose expected, std::uint32_t layer);

}  // namespace plumbline::firmware
