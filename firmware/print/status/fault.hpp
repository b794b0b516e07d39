#pragma once
/// Faults as users meet them: a stable code, what it means, what to do next. firmware/README.md has the table.

#include <cstdint>
#include <string_view>

#include "firmware/io/text/fixed_text.hpp"
#include "firmware/messages/catalogue.hpp"
#include "slicer/core/error.hpp"

namespace plumbline::firmware {

/// The number is the code: kLampStuckOn is PL-301. Numbers are never reused.
enum class FaultCode : std::uint16_t {
  kNone = 0,
  kScanUnreadable = 101,
  kNotAScan = 102,
  kNothingToPrint = 103,
  kOutOfMemory = 104,
  kDoesNotFit = 105,
  kBadSetting = 106,
  kStickGone = 107,
  kNoStick = 108,
  kStickUnreadable = 109,
  kCannotWrite = 110,
  kIssueFound = 111,
  kJournalDamaged = 120,
  kJournalOfAnother = 121,
  kFlipTimeout = 201,
  kPanelFailed = 202,
  kPanelSize = 203,
  kLampStuckOn = 301,
  kLampDead = 302,
  kLampKeeper = 303,
  kExposureTooLong = 304,
  kDoseOff = 305,
  kTooLittleLight = 306,
  kEndStopNotFound = 401,
  kEndStopStuck = 402,
  kStageStalled = 403,
  kOutsideTravel = 404,
  kStepsLost = 405,
  kCoverOpen = 501,
  kSensorDead = 601,
  kLampTooHot = 602,
  kResinTooCold = 603,
  kResinTooWarm = 604,
  kFanStalled = 605,
  kBoardTooHot = 606,
  kChamberFanStalled = 607,
  kPowerLost = 901,
  kDeviceTimeout = 902,
  kFirmware = 903,
};

/// "PL-301".
FixedText<16> to_string(FaultCode code);

/// @param code  not kNone
const FaultWords& info(FaultCode code, Language language = Language::kEnglish);

/// A fault as text for people.
struct FaultText {
  FixedText<800> what;    ///< "PL-601, sensor dead: the lamp's temperature sensor does not answer"
  FixedText<400> advice;  ///< "Check the sensor's plug, then resume."
};

/// @param code     not kNone
/// @param finding  what was found; may be empty
/// @param advice   of the error. If the fault is about a scan or a setting (PL-101 to PL-106) it replaces the table's
FaultText explain(FaultCode code, std::string_view finding, std::string_view advice = {});

/// The fault that an error of the slicer, a device or a file becomes.
FaultCode fault_of(ErrorCode code);

}  // namespace plumbline::firmware
