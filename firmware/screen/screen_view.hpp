#pragma once
/// What people have opened on the screen, and what the three buttons do there. Pure functions: who draws labels and who carries the buttons
/// out ask the same one.

#include <array>
#include <cstddef>
#include <cstdint>
#include <optional>

#include "firmware/messages/catalogue.hpp"
#include "firmware/state/command_rules.hpp"
#include "firmware/state/printer_record.hpp"

namespace plumbline::firmware::inline screen {

/// What the row at hand in the list of scans is, in the rows' order.
enum class ListRow : std::uint8_t {
  kScan,      ///< the job's
  kFolder,    ///< opens it
  kUp,        ///< opens the folder above
  kSettings,  ///< opens them
  kRemove,    ///< of an uploaded scan: deletes it
};
inline constexpr std::array kListRows = {ListRow::kScan, ListRow::kFolder, ListRow::kUp, ListRow::kSettings,
                                         ListRow::kRemove};

struct ScreenView {
  ListRow row = ListRow::kScan;
  std::size_t folder = 0;  ///< of kFolder
  bool settings_open = false;
  std::size_t setting = 0;      ///< the row at hand
  bool proposals_open = false;  ///< the best ways up, or the wait for them
  std::size_t proposal = 0;     ///< the row at hand
  bool asks_to_cancel = false;
  std::uint64_t job = 0;  ///< of asks_to_cancel: which print it is about
  bool asks_to_remove = false;
  std::size_t finding = 0;     ///< the one shown
  bool remedies_open = false;  ///< of that finding
  std::size_t remedy = 0;      ///< the row at hand: see remedy_rows()
  bool contract_open = false;
  std::size_t value = 0;     ///< the row at hand: see first_contract_row()
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
  kOpenFolder,
  kOpenSettings,
  kNextSetting,
  kChangeSetting,
  kCloseSettings,
  kOpenProposals,
  kNextProposal,
  kTakeProposal,
  kCloseProposals,
  kMoreFindings,
  kOpenRemedies,
  kNextRemedy,
  kTakeRemedy,
  kCloseRemedies,
  kOpenContract,
  kGoBack,  ///< from what has been sliced to its settings
  kRaiseValue,
  kLowerValue,
  kNextValue,
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

/// Rows of the contract: 0 goes back to the settings, row k + 1 is the value of PrintKey k.
inline constexpr std::size_t kContractRows = kPrintKeyCount + 1;
/// 1: nobody can go back, since the scan is no longer there.
std::size_t first_contract_row(const PrinterRecord& record);

/// One for each setting that mends the finding at hand, and one that leaves it as it is; 0: there is none, or the scan can't be
/// sliced anew.
std::size_t remedy_rows(const PrinterRecord& record, const ScreenView& view);

/// How many rows of a kind the list of scans has.
std::size_t rows_of(ListRow row, const PrinterRecord& record);
/// The row at hand, from the first one on.
std::size_t row_at(const PrinterRecord& record, const ScreenView& view);

/// By ScreenButton; none: the button does nothing.
std::array<std::optional<ButtonUse>, kScreenButtonCount> buttons_of(const PrinterRecord& record,
                                                                    const ScreenView& view);

/// The view without what the printer's state has closed.
ScreenView still_open(const PrinterRecord& record, ScreenView view);

}  // namespace plumbline::firmware::inline screen
