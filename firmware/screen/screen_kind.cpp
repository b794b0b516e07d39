#include "firmware/screen/screen_kind.hpp"

namespace plumbline::firmware::inline screen {

ScreenKind screen_of(const PrinterRecord& record) {
  switch (record.state) {
    case PrintState::kIdle: return ScreenKind::kIdle;
    case PrintState::kOffered: return record.sliced ? ScreenKind::kPreview : ScreenKind::kScans;
    case PrintState::kInterrupted: return ScreenKind::kInterrupted;
    case PrintState::kPlateInUse: return ScreenKind::kPlate;
    case PrintState::kSlicing: return ScreenKind::kSlicing;
    case PrintState::kChecks:
    case PrintState::kHoming: return ScreenKind::kChecks;
    case PrintState::kPrinting: return ScreenKind::kPrinting;
    case PrintState::kPausing:
    case PrintState::kPaused:
    case PrintState::kCoverOpen:
    case PrintState::kCoolingDown:
    case PrintState::kFeedMe: return ScreenKind::kPause;
    case PrintState::kCancelling:
    case PrintState::kFinishing: return ScreenKind::kRaising;
    case PrintState::kFinished:
    case PrintState::kCancelled: return ScreenKind::kPlate;
    case PrintState::kSuspended: return ScreenKind::kEnding;
    case PrintState::kFault: return ScreenKind::kFault;
  }
  return ScreenKind::kFault;
}

}  // namespace plumbline::firmware::inline screen
