#pragma once
/// What can go wrong in the plant, and how to ask for it. README.md has the table.

#include <cstdint>
#include <optional>
#include <span>
#include <string_view>

#include "hal/clock.hpp"
#include "slicer/core/error.hpp"

namespace plumbline::inline hal::inline sim {

enum class FaultKind : std::uint8_t {
  kLampStuckOn,
  kLampRunaway,
  kLampDead,
  kLampWeak,
  kLampDies,
  kLampFlickers,
  kLampSlowRise,
  kLampUnarmed,
  kPanelFlipTimeout,
  kPanelTorn,
  kPanelStale,
  kPanelDead,
  kPanelSlow,
  kStageEndStopStuck,
  kStageEndStopDead,
  kStageSkips,
  kStageStalls,
  kResinSticks,
  kResinWeak,
  kComputeSlow,
  kCoverOpens,
  kCoverSwitchDead,
  kStickPulled,
  kStickSlow,
  kStickBadSector,
  kStickMountFails,
  kTemperatureLampHot,
  kTemperatureLampSensorDead,
  kTemperatureResinCold,
  kTemperatureResinHot,
  kTemperatureResinSensorDead,
  kTemperatureResinSensorWild,
  kTemperatureBoardHot,
  kFanLampStalls,
  kFanChamberStalls,
  kButtonStart,
  kButtonPause,
  kButtonCancel,
  kSystemShutdown,
  kPowerCut,
};
inline constexpr std::size_t kFaultKindCount = 40;

/// When a fault for layer N starts.
enum class FaultMoment : std::uint8_t {
  kBeforeLayer,  ///< when the exposure of layer N-1 ends, for layer 0 at once: it affects everything done for layer N
  kInExposure,   ///< when the exposure of layer N begins
};

/// One row of the table.
struct FaultRow {
  FaultKind kind;
  std::string_view name;  ///< "lamp.stuck_on"
  FaultMoment moment = FaultMoment::kBeforeLayer;
  double amount = 0;           ///< without `by=`
  std::string_view by;         ///< unit and meaning of the amount; "": the fault has none
  double least = 0, most = 0;  ///< of the amount
  std::string_view what;       ///< what goes wrong
};

/// All kinds, in the order of FaultKind.
std::span<const FaultRow, kFaultKindCount> fault_table();
inline const FaultRow& row_of(FaultKind kind) { return fault_table()[static_cast<std::size_t>(kind)]; }

/// A requested fault.
struct Fault {
  FaultKind kind = FaultKind::kPowerCut;
  std::optional<std::uint32_t> layer;  ///< 0-based; none: the fault starts at a time
  nanoseconds delay{};                 ///< after the layer's moment; without a layer, after the plant's start
  std::optional<nanoseconds> lasts;    ///< none: forever
  double amount = 0;
};

/// Parses a fault, written without blanks:
///
///   device.fault @ layer=N [+SECONDSs] [,for=SECONDSs] [,by=AMOUNT]        stage.skips@layer=40,by=0.2
///   device.fault @ t=SECONDSs [,for=SECONDSs] [,by=AMOUNT]                 cover.opens@t=123.4s,for=5s
///
/// Seconds are 0 to 1e8.
/// @retval ErrorCode::kBadSetting  what is wrong and what is allowed; for an unknown fault, the nearest known one
[[nodiscard]] Expected<Fault> parse_fault(std::string_view all);

}  // namespace plumbline::inline hal::inline sim
