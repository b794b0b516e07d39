#include "firmware/print/status/fault.hpp"

#include <algorithm>
#include <cassert>
#include <cctype>

namespace plumbline::firmware {

FixedText<16> to_string(FaultCode code) {
  FixedText<16> text;
  text.add("PL-%u", static_cast<unsigned>(code));
  return text;
}

FaultText explain(FaultCode code, std::string_view finding, std::string_view advice) {
  const FaultWords& fault = info(code);
  FaultText text;
  text.what.add("%s, %.*s%s%.*s", to_string(code).c_str(), static_cast<int>(fault.title.size()), fault.title.data(),
                finding.empty() ? "" : ": ", static_cast<int>(finding.size()), finding.data());
  // An error about a scan or a setting gives better advice than the table: it has the numbers. A device can't advise to resume.
  if (advice.empty() || code > FaultCode::kBadSetting) advice = fault.next;
  text.advice.add("%c%.*s%s", std::toupper(static_cast<unsigned char>(advice[0])), static_cast<int>(advice.size()) - 1,
                  advice.data() + 1, advice.ends_with('.') ? "" : ".");
  return text;
}

const FaultWords& info(FaultCode code, Language language) {
  const auto faults = fault_words(language);
  const auto found = std::find_if(faults.begin(), faults.end(), [code](const FaultWords& fault) {
    return fault.number == static_cast<std::uint16_t>(code);
  });
  assert(found != faults.end());
  return *found;
}

FaultCode fault_of(ErrorCode code) {
  switch (code) {
    case ErrorCode::kCannotOpen:
    case ErrorCode::kCannotRead: return FaultCode::kScanUnreadable;
    case ErrorCode::kCannotWrite: return FaultCode::kCannotWrite;
    case ErrorCode::kUnknownFormat:
    case ErrorCode::kMalformed:
    case ErrorCode::kTruncated:
    case ErrorCode::kUnsupported: return FaultCode::kNotAScan;
    case ErrorCode::kNoPoints:
    case ErrorCode::kNoSurface: return FaultCode::kNothingToPrint;
    case ErrorCode::kOutOfMemory: return FaultCode::kOutOfMemory;
    case ErrorCode::kDoesNotFit: return FaultCode::kDoesNotFit;
    case ErrorCode::kBadSetting: return FaultCode::kBadSetting;
    case ErrorCode::kPowerLost: return FaultCode::kPowerLost;
    case ErrorCode::kDeviceTimeout: return FaultCode::kDeviceTimeout;
    case ErrorCode::kNoStick: return FaultCode::kNoStick;
    case ErrorCode::kStickGone: return FaultCode::kStickGone;
    case ErrorCode::kMountFailed: return FaultCode::kStickUnreadable;
    case ErrorCode::kFlipTimeout: return FaultCode::kFlipTimeout;
    case ErrorCode::kPanelFailed: return FaultCode::kPanelFailed;
    case ErrorCode::kExposureTooLong: return FaultCode::kExposureTooLong;
    case ErrorCode::kLampStuckOn: return FaultCode::kLampStuckOn;
    case ErrorCode::kLampDead: return FaultCode::kLampDead;
    case ErrorCode::kDoseOff: return FaultCode::kDoseOff;
    case ErrorCode::kLampFailed: return FaultCode::kLampKeeper;
    case ErrorCode::kOutsideTravel: return FaultCode::kOutsideTravel;
    case ErrorCode::kEndStopNotFound: return FaultCode::kEndStopNotFound;
    case ErrorCode::kEndStopStuck: return FaultCode::kEndStopStuck;
    case ErrorCode::kStageStalled: return FaultCode::kStageStalled;
    case ErrorCode::kCoverOpen: return FaultCode::kCoverOpen;
    case ErrorCode::kSensorDead: return FaultCode::kSensorDead;
    case ErrorCode::kCancelled:
    case ErrorCode::kBusy:
    case ErrorCode::kMaskNotPresented:
    case ErrorCode::kLampLit:
    case ErrorCode::kNotHomed:
    case ErrorCode::kStageMoving: return FaultCode::kFirmware;
  }
  return FaultCode::kFirmware;
}

}  // namespace plumbline::firmware
