#pragma once
/// What is said to people, as a code with its values. The English sentence goes beside it; whoever shows it in another language words the code.

#include <algorithm>
#include <array>
#include <cstddef>
#include <cstdint>
#include <initializer_list>
#include <string_view>
#include <type_traits>

namespace plumbline {

/// to_string() has the words of the state socket, which never change.
enum class ToldCode : std::uint16_t {
  kNone,
  // What the checks of the masks find, in the order of IssueKind.
  kIsland,
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
  kTooWide,
  kTooDeep,
  kTooHigh,
  kTooHighOnSupports,
  kTooManySupports,
  kMemoryNeeded,
  kTooSmall,
  kBelowFloor,
  kNoTriangles,
  kSurfaceNotFound,
  kMeshChanged,
  kNotPoints,
  kNoFaces,
  kLaz,
  kSplatsCompressed,
  kFileEmpty,
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
  kStickForeign,
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
inline constexpr std::size_t kToldCodeCount = static_cast<std::size_t>(ToldCode::kCodesTooMany) + 1;

/// A number that is told, with its unit.
enum class Fact : std::uint8_t {
  kCount,
  kOf,     ///< of how many
  kLayer,  ///< as numbered in reports, from 0
  kFirstLayer,
  kLastLayer,
  kLayers,
  kFromMm,  ///< height above the plate
  kXMm,
  kYMm,
  kAreaMm2,
  kVolumeMl,
  kPercent,
  kPoints,
  kLongestMm,
  kWidthMm,
  kDepthMm,
  kHeightMm,
  kLiftMm,
  kLimitMm,
  kExcessMm,
  kOffMm,
  kCellMm,
  kPixelMm,
  kCureMm,
  kFloor,  ///< in the scan's unit
  kTurnXDeg,
  kTurnYDeg,
  kNeededMib,
  kAvailableMib,
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
inline constexpr std::size_t kFactCount = static_cast<std::size_t>(Fact::kTotalMb) + 1;

/// How a fact is called on the state socket, and how many of its digits a person wants to see.
struct FactFormat {
  std::string_view name;  ///< "area_mm2"
  int decimals = 0;       ///< digits behind the point; below 0: so many digits in all
};

/// Plain numbers and characters, so that a process can hand it to another: is_valid() says whether it can be one.
struct Told {
  static constexpr std::size_t kMostFacts = 8;
  struct Number {
    template <class T>
    requires std::is_arithmetic_v<T> Number(Fact what, T number) : fact(what), value(static_cast<double>(number)) {}
    Fact fact;
    double value;
  };

  ToldCode code = ToldCode::kNone;
  std::uint8_t count = 0;
  std::array<Fact, kMostFacts> facts{};
  std::array<double, kMostFacts> values{};
  std::array<char, 40> text{};  ///< a name, which has no language; ends with NUL

  Told() = default;
  Told(ToldCode what, std::initializer_list<Number> numbers = {}, std::string_view name = {});

  /// Adds a number; there is room for kMostFacts.
  template <class T>
  void add(Fact fact, T number) {
    add(Number(fact, number));
  }
  void add(const Number& number);
  bool empty() const { return code == ToldCode::kNone; }
  std::string_view name() const { return text.data(); }
  /// The value of a fact; NaN if it is not told.
  double of(Fact fact) const;
  bool is_valid() const;
};

/// "island", "too_high", ...
std::string_view to_string(ToldCode code);
const FactFormat& format_of(Fact fact);

}  // namespace plumbline
