#pragma once
/// What people have opened on the screen, and what the three buttons do there. Pure functions: who draws labels and who carries the buttons
/// out ask the same one.

#include <array>
#include <cstddef>
#include <cstdint>
#include <optional>

#include "firmware/screen/words.hpp"
#include "firmware/state/command_rules.hpp"
#include "firmware/state/printer_record.hpp"

namespace plumbline {

/// A row of the list of scans that is no scan. They come last.
enum class ListRow : std::uint8_t {
  kScan,      ///< the job's
  kSettings,  ///< opens them
  kRemove,    ///< of an uploaded scan: deletes it
};

struct ScreenView {
  ListRow row = ListRow::kScan;
  bool settings_open = false;
  std::size_t setting = 0;      ///< the row at hand
  bool proposals_open = false;  ///< the best ways up, or the wait for them
  std::size_t proposal = 0;     ///< the row at hand
  bool asks_to_cancel = false;
  bool asks_to_remove = false;
  std::size_t finding = 0;   ///< the first one shown
  bool prints_open = false;  ///< the last prints
  std::size_t print = 0;     ///< the row at hand
  bool lights_open = false;  ///< the card of lights and buzzer
  std::size_t pattern = 0;   ///< the row at hand
};

enum class ScreenButton : std::uint8_t { kStart, kPause, kCancel };
inline constexpr std::size_t kScreenButtonCount = 3;

enum class ButtonAct : std::uint8_t {
  kCommand,  ///< goes on to the printer
  kNextScan,
  kOpenSettings,
  kNextSetting,
  kChangeSetting,
  kCloseSettings,
  kOpenProposals,
  kNextProposal,
  kTakeProposal,
  kCloseProposals,
  kMoreFindings,
  kAskToCancel,
  kAskToRemove,
  kRemove,
  kKeep,  ///< the print or the scan: the question is closed
  kOpenPrints,
  kNextPrint,
  kClosePrints,
  kOpenLights,
  kNextPattern,
  kCloseLights,
};

struct ButtonUse {
  Words label;
  ButtonAct act = ButtonAct::kCommand;
};

/// Whether the list of scans has a row that deletes the uploaded one.
bool has_remove_row(const PrinterRecord& record);

/// By ScreenButton; none: the button does nothing.
std::array<std::optional<ButtonUse>, kScreenButtonCount> buttons_of(const PrinterRecord& record,
                                                                    const ScreenView& view);

/// The view without what the printer's state has closed.
ScreenView still_open(const PrinterRecord& record, ScreenView view);

}  // namespace plumbline
