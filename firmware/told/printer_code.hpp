#pragma once
/// Codes and facts of the printer's messages, numbered on from the slicer's, and the names of all of them on the state socket.

#include <cstddef>
#include <cstdint>
#include <string_view>

#include "slicer/core/words/told.hpp"

namespace plumbline {

enum class PrinterCode : std::uint16_t {
  // Findings of the mask checks, in the order of IssueKind.
  kIsland = kToldCodeCount,
  kOverhang,
  kFreePiece,
  kTear,
  kResinTrap,
  kSuctionCup,
  kTouchingBound,
  kEmptyLayer,
  kPrintHeight,
  kFirstLayerArea,
  kPeelArea,
  kPeelJump,
  // What was left out of a scan or changed in it.
  kUnitsIgnored,
  kUnitsGuessed,
  kObjectSmall,
  kObjectLarge,
  kObjectThin,
  kPointsAveraged,
  kNoiseAveraged,
  kTrianglesLeftOut,
  kFacesTurned,
  kMeshOpen,
  kSmallHolesClosed,
  kRaysCrowded,
  kFloorCut,
  kPiecesLeftOut,
  kNormalsAtRandom,
  kInsideOut,
  kNormalsFlipped,
  kSolidsLeftOut,
  kMuchRemoved,
  kManyOutliers,
  kCavitiesFilled,
  kSmallPartsStay,
  kOnItsFace,
  kLiesWrong,
  kNormalsEstimated,
  // What a print's report warns of.
  kMayShowMark,
  kMasksLate,
  kDosesOff,
  kStepsLost,
  kReportFull,
  // Why a scan is refused, if nothing more is known than the kind of its error.
  kFileNotOpened,
  kFileNotRead,
  kFormatUnknown,
  kFileDamaged,
  kFileCut,
  kNothingToPrint,
  kVariantUnknown,
  kMemoryShort,
  kTooLarge,
  kSettingWrong,
  kNoSurface,
  // Why a scan is refused.
  kBadSectors,
  kReadingBroke,
  kArchivePixels,
  kArchivePanel,
  kArchiveHigh,
  kExposureLong,
  kLightLong,
  kStageSlow,
  kLastLiftHigh,
  kProfileUnknown,
  kStickEmpty,
  kStickTwoJobs,
  kStickOtherJob,
  kStickInnerJob,
  kTooManyFiles,
  kArchiveSettings,
  kSettingUnknown,
  kSettingValue,
  // What a paused print asks.
  kMeasurePart,
  kLookAtPlate,
  // What the printer says beside its state.
  kStickMayGo,
  kReportsOnStick,
  kReportsNotOnStick,
  // What the checks before a print have found.
  kCheckMemory,
  kCheckObject,
  kCheckObjectHangs,
  kCheckMasksClean,
  kCheckMasksIssues,
  kCheckMasksBefore,
  kCheckLight,
  kCheckLampDark,
  kCheckLampLit,
  kCheckPanel,
  kCheckPanelOther,
  kCheckCoverClosed,
  kCheckCoverOpen,
  kCheckCoverNone,
  kCheckTemperatures,
  kCheckResin,
  kCheckResinShort,
  kCheckJournal,
  kCheckJournalNone,
  kCheckJournalDoubt,
  kCheckStage,
  // Why a scan is not uploaded or not deleted.
  kUploadsOff,
  kUploadName,
  kUploadKind,
  kUploadEmpty,
  kUploadLarge,
  kUploadNoRoom,
  kUploadNotNow,
  kUploadOther,
  kUploadJobBegan,
  kUploadBroke,
  kUploadSlow,
  kUploadNotStored,
  kUploadReplaced,
  kNotInStore,
  kNotRemoved,
  // Why a command is refused.
  kCommandNotNow,
  kNoSuchScan,
  kCodeWrong,
  kCodeOld,
  kCodesTooMany,
};
template <>
inline constexpr bool kExtends<PrinterCode, ToldCode> = true;
/// Of the slicer and the printer together.
inline constexpr std::size_t kAllCodes = static_cast<std::size_t>(PrinterCode::kCodesTooMany) + 1;

enum class PrinterFact : std::uint8_t {
  kOffMm = kFactCount,
  kCureMm,
  kColumns,
  kRows,
  kPanelColumns,
  kPanelRows,
  kPanelWidthMm,
  kPanelDepthMm,
  kExposureS,
  kLimitS,
  kSpeedMmMin,
  kLimitMmMin,
  kNeededMl,
  kTankMl,
  kLampC,
  kLampLimitC,
  kResinC,
  kResinLeastC,
  kResinMostC,
  kReceivedMb,
  kTotalMb,
};
template <>
inline constexpr bool kExtends<PrinterFact, Fact> = true;
inline constexpr std::size_t kAllFacts = static_cast<std::size_t>(PrinterFact::kTotalMb) + 1;

/// A fact's name on the state socket, and how many of its digits are shown.
struct FactFormat {
  std::string_view name;  ///< "area_mm2"
  int decimals = 0;       ///< digits after the point; if negative, significant digits
};

/// The code's key on the state socket, which never changes: "island", "too_high", ...
std::string_view to_string(ToldCode code);
const FactFormat& format_of(Fact fact);

/// Whether a message from another process has a known code, known facts and finite values.
bool is_valid(const Told& told);

}  // namespace plumbline
