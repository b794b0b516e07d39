#pragma once
/// All texts of the printer's screen, in every language.

#include <cstdint>
#include <string_view>

#include "firmware/settings/language.hpp"

namespace plumbline {

enum class Words : std::uint8_t {
  // Titles, a screen each.
  kReady,
  kScans,
  kUploadedScan,
  kSettings,
  kReading,
  kPreview,
  kChecks,
  kHoming,
  kPrinting,
  kCancelQuestion,
  kPausing,
  kPaused,
  kCoverOpen,
  kCoolingDown,
  kResinLow,
  kRaising,
  kFinished,
  kCancelled,
  kPlateInUse,
  kInterrupted,
  kEnding,
  kFault,
  kPrints,
  // What there is to do, in large letters, and what else there is to say.
  kPlugIn,
  kScanKinds,
  kStickIsIn,
  kShowAgain,
  kJobFileAsks,
  kScansAsOne,
  kEmptyStick,
  kPleaseWait,
  kStep,
  kNoPicture,
  kLayers,
  kNoFindings,
  kPartIsRaised,
  kAskedToCancel,
  kAfterLayer,
  kPressToGoOn,
  kCloseCover,
  kLampCools,
  kRefill,
  kTakePartOff,
  kIsPlateEmpty,
  kCanGoOn,
  kGoOnOrGiveUp,
  kLayerOf,
  kTimeLeft,
  // Settings and their values.
  kProfile,
  kSize,
  kTurn,
  kTilt,
  kUpright,
  kSupports,
  kLayerHeight,
  kAsScanned,
  kOfProfile,
  kYes,
  kNo,
  // Checks, in the order of Check.
  kCheckMemory,
  kCheckObject,
  kCheckMasks,
  kCheckLight,
  kCheckLampDark,
  kCheckPanel,
  kCheckCover,
  kCheckTemperatures,
  kCheckResin,
  kCheckJournal,
  kCheckStage,
  // Buttons.
  kDoPrint,
  kDoNext,
  kDoDecline,
  kDoOffer,
  kDoOpen,
  kDoChange,
  kDoBack,
  kDoStop,
  kDoMore,
  kDoPause,
  kDoCancel,
  kDoKeepPrinting,
  kDoEndPrint,
  kDoResume,
  kDoGiveUp,
  kDoEmpty,
  kDoSeen,
  kDoPrints,
  // In the place of any title.
  kPageCode,
};
inline constexpr std::size_t kWordsCount = static_cast<std::size_t>(Words::kPageCode) + 1;

/// Some have places for numbers, as printf has them: kStep and kLayerOf two %u, kLayers and kScansAsOne one, kTimeLeft and kPageCode a %s.
std::string_view words(Words which, Language language);

}  // namespace plumbline
