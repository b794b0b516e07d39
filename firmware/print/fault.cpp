#include "firmware/print/fault.hpp"

#include <algorithm>
#include <cassert>

namespace plumbline {
namespace {

constexpr std::array kFaults{
    FaultInfo{FaultCode::kScanUnreadable, "scan can't be read", "The file could not be opened, or its medium failed.",
              "Check name and medium, copy the scan again."},
    FaultInfo{FaultCode::kNotAScan, "not a scan", "The file is of no kind that plumbline reads, or it is damaged.",
              "Export the scan again as PLY, PCD, OBJ or XYZ."},
    FaultInfo{FaultCode::kNothingToPrint, "nothing to print", "There are no points in the scan, or no surface in them.",
              "Look at the scan in the scanner's program; export it with its points."},
    FaultInfo{FaultCode::kOutOfMemory, "does not fit into memory", "The job needs more than the printer's arena.",
              "Print it smaller, or with thicker layers."},
    FaultInfo{FaultCode::kDoesNotFit, "does not fit the printer", "The object is larger than the plate or the travel.",
              "Scale or turn it; the message says by how much."},
    FaultInfo{FaultCode::kBadSetting, "wrong setting", "A key of a board file, a profile or job.toml is wrong.",
              "Correct the line that the message names."},
    FaultInfo{FaultCode::kStickGone, "stick pulled", "The stick was pulled while the scan was being read.",
              "Plug it in again; the job starts anew."},
    FaultInfo{FaultCode::kNoStick, "no stick", "There is no stick in the port.", "Plug one in."},
    FaultInfo{FaultCode::kStickUnreadable, "stick can't be read", "The stick has no file system that can be read.",
              "Format it as FAT32 or exFAT, and copy the scan again."},
    FaultInfo{FaultCode::kCannotWrite, "journal can't be written", "The printer's own storage is full or fails.",
              "Make room or replace the storage; without a journal a power cut ends a print for good."},
    FaultInfo{FaultCode::kJournalDamaged, "journal damaged", "What was stored of an interrupted print is damaged.",
              "It can't be gone on with: take the part off, start anew."},
    FaultInfo{FaultCode::kJournalOfAnother, "journal of another printer",
              "The interrupted print was made with another printer's file or another version.",
              "Resume with the board file of that print, or take the part off and start anew."},
    FaultInfo{FaultCode::kFlipTimeout, "panel did not take a mask", "The panel took too long to show a picture.",
              "Check the panel's cable, then resume."},
    FaultInfo{FaultCode::kPanelFailed, "panel does not answer", "No picture can be shown.",
              "Check the panel's cable, then resume."},
    FaultInfo{FaultCode::kPanelSize, "wrong panel", "The panel has other pixels than the board file says.",
              "Use the board file of this printer."},
    FaultInfo{FaultCode::kLampStuckOn, "lamp stuck on", "There is light although the lamp was turned off.",
              "Pull the plug, now. Have the lamp's driver replaced."},
    FaultInfo{FaultCode::kLampDead, "lamp dead", "There is no light although the lamp was turned on.",
              "Check lamp, cable and fuse, then resume."},
    FaultInfo{FaultCode::kLampKeeper, "lamp not guarded", "Turning the lamp off could not be armed, so it stayed dark.",
              "Switch the printer off and on, then resume."},
    FaultInfo{FaultCode::kExposureTooLong, "exposure too long", "The profile exposes longer than the lamp may be lit.",
              "Lower exposure_time or initial_exposure_time."},
    FaultInfo{FaultCode::kDoseOff, "dose off", "The lamp gave more than 5 % more or less light than it should.",
              "Have the lamp measured, correct power_mw_cm2, then resume."},
    FaultInfo{FaultCode::kTooLittleLight, "too little light",
              "With this exposure the resin would not set through a whole layer.",
              "Raise exposure_time, or use the profile of this resin."},
    FaultInfo{FaultCode::kEndStopNotFound, "end stop not found", "Homing went its whole way.",
              "Check the end stop's switch and cable, then resume."},
    FaultInfo{FaultCode::kEndStopStuck, "end stop stuck", "The end stop is pressed where it can't be.",
              "Free its switch, then resume."},
    FaultInfo{FaultCode::kStageStalled, "stage stalled", "The motor could not follow.",
              "Look for what blocks the stage, then resume."},
    FaultInfo{FaultCode::kOutsideTravel, "outside the travel", "A height was asked for that the stage can't reach.",
              "Print the object lower, or correct the board file."},
    FaultInfo{FaultCode::kStepsLost, "steps lost", "The stage was not where its steps said.",
              "Look for what blocks the stage; the print may have a step where it went on."},
    FaultInfo{FaultCode::kCoverOpen, "cover open", "The cover was open when the print was to start.",
              "Close it and start again."},
    FaultInfo{FaultCode::kSensorDead, "sensor dead", "A temperature sensor does not answer.",
              "Check its plug, then resume."},
    FaultInfo{FaultCode::kLampTooHot, "lamp too hot", "The lamp was above its limit when the print was to start.",
              "Wait until it is cool; look whether its fan turns."},
    FaultInfo{FaultCode::kResinTooCold, "resin too cold", "Cold resin is thick and does not cure as it should.",
              "Warm the room or the resin, then start again."},
    FaultInfo{FaultCode::kResinTooWarm, "resin too warm", "Warm resin cures too deep.",
              "Let it cool, then start again."},
    FaultInfo{FaultCode::kFanStalled, "fan stalled", "The lamp's fan does not turn although it is to.",
              "Clean or replace it, then resume."},
    FaultInfo{FaultCode::kPowerLost, "power lost", "The supply failed.", "Switch on and resume."},
    FaultInfo{FaultCode::kDeviceTimeout, "device does not answer", "A device did not end what it had begun.",
              "Switch the printer off and on, then resume."},
    FaultInfo{FaultCode::kFirmware, "mistake in the firmware",
              "The firmware asked a device for what must not be, and was refused.",
              "Resume, and report the message to plumbline's maintainers."},
};

}  // namespace

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
