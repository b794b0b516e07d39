#include "firmware/print/status/fault.hpp"

#include <algorithm>
#include <cassert>
#include <cctype>

namespace plumbline {
namespace {

constexpr std::array kFaults{
    FaultInfo{FaultCode::kScanUnreadable, "scan can't be read", "The file can't be opened, or its medium failed.",
              "Check the name and the medium, or copy the scan again."},
    FaultInfo{FaultCode::kNotAScan, "not a scan", "The file is damaged, or of a kind that plumbline does not read.",
              "Export it again: a scan as PLY, PCD, OBJ or XYZ, a mesh as STL, OBJ, PLY, OFF or 3MF."},
    FaultInfo{FaultCode::kNothingToPrint, "nothing to print",
              "The scan has no points, no surface, or nothing that stands on the plate.",
              "Look at the scan in the scanner's program, then export it with its points."},
    FaultInfo{FaultCode::kOutOfMemory, "does not fit into memory", "The job needs more than the printer's arena.",
              "Print the object smaller, or with thicker layers."},
    FaultInfo{FaultCode::kDoesNotFit, "does not fit the printer", "The object is larger than the plate or the travel.",
              "Scale the object down, or turn it."},
    FaultInfo{FaultCode::kBadSetting, "wrong setting", "A key of a board file, a profile or job.toml is wrong.",
              "Correct the line that the message names."},
    FaultInfo{FaultCode::kStickGone, "stick pulled", "The stick was pulled while the scan was being read.",
              "Plug the stick in again; the job starts from the beginning."},
    FaultInfo{FaultCode::kNoStick, "no stick", "There is no stick in the port.", "Plug a stick in."},
    FaultInfo{FaultCode::kStickUnreadable, "stick can't be read", "The stick has no file system that can be read.",
              "Format the stick as FAT32 or exFAT, then copy the scan again."},
    FaultInfo{FaultCode::kCannotWrite, "journal can't be written", "The printer's own storage is full or fails.",
              "Make room or replace the storage. Without a journal a power cut ends a print for good."},
    FaultInfo{FaultCode::kIssueFound, "issue in the layers",
              "The layers have something that the profile refuses to print.",
              "Turn the object or add supports, or change [checks] in the profile."},
    FaultInfo{FaultCode::kJournalDamaged, "journal damaged",
              "What was stored of an interrupted print is damaged, so that print can't be resumed.",
              "Take the part off the plate, then start the print again."},
    FaultInfo{FaultCode::kJournalOfAnother, "journal of another printer",
              "The interrupted print was made with another board file or by another version of plumbline.",
              "Resume with the board file and version of that print, or take the part off the plate and start again."},
    FaultInfo{FaultCode::kFlipTimeout, "panel did not take a mask", "The panel took too long to show a mask.",
              "Check the panel's cable, then resume."},
    FaultInfo{FaultCode::kPanelFailed, "panel does not answer", "No mask can be shown.",
              "Check the panel's cable, then resume."},
    FaultInfo{FaultCode::kPanelSize, "wrong panel", "The panel has another number of pixels than the board file says.",
              "Use the board file of this printer."},
    FaultInfo{FaultCode::kLampStuckOn, "lamp stuck on", "There is light although the lamp was turned off.",
              "Pull the plug now, then have the lamp's driver replaced."},
    FaultInfo{FaultCode::kLampDead, "lamp dead", "There is no light although the lamp was turned on.",
              "Check the lamp, its cable and its fuse, then resume."},
    FaultInfo{
        FaultCode::kLampKeeper, "lamp not guarded",
        "The keeper, which turns the lamp off in time, failed or did not answer. The lamp stayed dark or was turned "
        "off.",
        "Resume. If it happens again, switch the printer off and on."},
    FaultInfo{FaultCode::kExposureTooLong, "exposure too long",
              "The profile exposes for longer than the lamp may be lit.",
              "Lower exposure_time or initial_exposure_time."},
    FaultInfo{FaultCode::kDoseOff, "dose off", "The lamp gave over 5 % more or less light than asked for.",
              "Have the lamp measured, correct power_mw_cm2, then resume."},
    FaultInfo{FaultCode::kTooLittleLight, "too little light",
              "At this exposure the resin would not cure through a whole layer.",
              "Raise exposure_time, or use the profile of this resin."},
    FaultInfo{FaultCode::kEndStopNotFound, "end stop not found",
              "Homing travelled the whole way without meeting the end stop.",
              "Check the end stop's switch and cable, then resume."},
    FaultInfo{FaultCode::kEndStopStuck, "end stop stuck", "The end stop is pressed where it can't be.",
              "Free the end stop's switch, then resume."},
    FaultInfo{FaultCode::kStageStalled, "stage stalled", "The motor could not follow.",
              "Look for what blocks the Z stage, then resume."},
    FaultInfo{FaultCode::kOutsideTravel, "outside the travel", "A height was asked for that the Z stage can't reach.",
              "Make the object lower, or correct the board file."},
    FaultInfo{FaultCode::kStepsLost, "steps lost", "The Z stage was not where its steps said.",
              "Look for what blocks the Z stage, and look at the part for a step."},
    FaultInfo{FaultCode::kCoverOpen, "cover open", "The cover was open when the print was to start.",
              "Close the cover, then start again."},
    FaultInfo{FaultCode::kSensorDead, "sensor dead", "A temperature sensor does not answer, or says what can't be.",
              "Check the sensor's plug, then resume."},
    FaultInfo{FaultCode::kLampTooHot, "lamp too hot", "The lamp is above its limit.",
              "Check that its fan turns. The print goes on by itself when the lamp is cool."},
    FaultInfo{FaultCode::kResinTooCold, "resin too cold", "Cold resin is thick and cures too little.",
              "Warm the room or the resin. The print goes on by itself."},
    FaultInfo{FaultCode::kResinTooWarm, "resin too warm", "Warm resin cures too deep.",
              "Let the resin cool. The print goes on by itself."},
    FaultInfo{FaultCode::kFanStalled, "fan stalled", "The lamp's fan is on and does not turn.",
              "Clean or replace the fan. The print goes on by itself when it turns."},
    FaultInfo{FaultCode::kBoardTooHot, "board too hot", "The printer's processor is above its limit.",
              "Let air to it. The print goes on by itself when it is cool."},
    FaultInfo{FaultCode::kChamberFanStalled, "chamber fan stalled",
              "The fan that extracts the vapour is on and does not turn.",
              "Clean or replace the fan. The print goes on by itself when it turns."},
    FaultInfo{FaultCode::kPowerLost, "power lost", "The supply failed.", "Switch the printer on, then resume."},
    FaultInfo{FaultCode::kDeviceTimeout, "device does not answer", "A device did not finish what it had begun.",
              "Switch the printer off and on, then resume."},
    FaultInfo{FaultCode::kFirmware, "mistake in the firmware",
              "The firmware asked a device for something that is not allowed, and was refused.",
              "Resume, and report the message to plumbline's maintainers."},
};

}  // namespace

FaultText explain(FaultCode code, std::string_view finding, std::string_view advice) {
  const FaultInfo& fault = info(code);
  FaultText text;
  text.what.add("PL-%u, %.*s%s%.*s", static_cast<unsigned>(code), static_cast<int>(fault.title.size()),
                fault.title.data(), finding.empty() ? "" : ": ", static_cast<int>(finding.size()), finding.data());
  // An error about a scan or a setting gives better advice than the table: it has the numbers. A device can't advise to resume.
  if (advice.empty() || code > FaultCode::kBadSetting) advice = fault.next;
  text.advice.add("%c%.*s%s", std::toupper(static_cast<unsigned char>(advice[0])), static_cast<int>(advice.size()) - 1,
                  advice.data() + 1, advice.ends_with('.') ? "" : ".");
  return text;
}

std::span<const FaultInfo> all_faults() { return kFaults; }

const FaultInfo& info(FaultCode code) {
  const auto* const found =
      std::find_if(kFaults.begin(), kFaults.end(), [code](const FaultInfo& fault) { return fault.code == code; });
  assert(found != kFaults.end());
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

}  // namespace plumbline
