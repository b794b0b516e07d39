#pragma once
/// What a person may ask of the printer, and when. Pure functions.

#include <array>
#include <cstdint>
#include <optional>
#include <string_view>

#include "firmware/print/status/print_state.hpp"
#include "firmware/state/printer_record.hpp"
#include "hal/events.hpp"

namespace plumbline {

enum class Command : std::uint8_t {
  kStart,       ///< print the job that is offered
  kPause,       ///< raise the part after this layer, and wait
  kResume,      ///< go on after a pause, or with an interrupted print
  kCancel,      ///< decline what is offered, stop reading, end the print
  kPlateEmpty,  ///< somebody has looked: the plate is empty
  kSeen,        ///< somebody has read the fault
  kOffer,       ///< offer what is on the stick again
  kChoose,      ///< a scan on the stick
  kSet,         ///< a setting of the job that is offered
  kPicture,     ///< a question that changes nothing: whoever may read may ask it
};
/// Without kPicture, which no state's list of commands has.
inline constexpr std::size_t kCommandCount = 9;

/// "start", "plate-empty", ...
std::string_view to_string(Command command);
std::optional<Command> command_of(std::string_view word);

/// Whether the printer takes a command now.
bool takes(const PrinterRecord& record, Command command);

/// "the printer is printing: it takes pause, cancel"
FixedText<200> what_it_takes(const PrinterRecord& record);

/// The button that does the same; none: the daemon does it itself (choose, set).
/// @pre takes()
std::optional<EventKind> button_of(Command command);

}  // namespace plumbline
