#pragma once
/// Checks for every layer: temperatures before its light, the dose after it.

#include "firmware/io/text/fixed_text.hpp"
#include "firmware/print/plan/print_settings.hpp"
#include "firmware/print/status/fault.hpp"
#include "hal/thermals.hpp"
#include "hal/uv_lamp.hpp"
#include "slicer/core/error.hpp"

namespace plumbline {

struct LayerFinding {
  FaultCode fault = FaultCode::kNone;  ///< kNone: all is well
  FixedText<160> text;
};

/// Whether lamp and resin are within their limits.
/// @returns kLampTooHot, kResinTooCold, kResinTooWarm, or kNone
FaultCode temperature_fault(Celsius lamp, Celsius resin, const PrintSettings& settings);

/// @returns kFanStalled or temperature_fault(). A lamp that is too hot need not end a print: it can cool down
/// @retval ErrorCode::kSensorDead, kPowerLost
[[nodiscard]] Expected<LayerFinding> check_temperatures(const Thermals& thermals, const PrintSettings& settings);

/// How far a measured dose is off, as a share of the expected one.
double dose_error(const ExposureReport& exposure, Dose expected);
/// Doses that are off by more are counted for the report.
inline constexpr double kDoseNoted = 0.01;

/// @param layer  from 0
/// @returns kDoseOff or kNone
LayerFinding check_dose(const ExposureReport& exposure, Dose expected, std::uint32_t layer);

}  // namespace plumbline
