#pragma once

#include <cstdint>

#include "firmware/state/printer_record.hpp"

namespace plumbline::firmware::inline screen {

enum class ScreenKind : std::uint8_t {
  kIdle,
  kScans,     ///< those on the stick, to choose from
  kPreview,   ///< of what has been sliced, to start or decline
  kSlicing,   ///< a scan is read
  kChecks,    ///< checks and homing
  kPrinting,  ///<
  kPause,     ///< of any kind, with its reason
  kRaising,   ///< at the end of a print
  kPlate,     ///< the part is to be taken off
  kInterrupted,
  kFault,
  kEnding,  ///< the system shuts down
};
inline constexpr std::size_t kScreenKindCount = 12;

/// The screen of a state. Total.
ScreenKind screen_of(const PrinterRecord& record);

}  // namespace plumbline::firmware::inline screen
