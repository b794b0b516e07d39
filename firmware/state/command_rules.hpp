#pragma once
/// What a person may ask of the printer, and when. Pure functions.

#include <array>
#include <cstdint>
#include <optional>
#include <string_view>

#include "firmware/print/status/print_state.hpp"
#include "firmware/state/printer_record.hpp"
#include "hal/events.hpp"

namespace plumbline::firmware::inline state {

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
  kRemove,      ///< the uploaded scan, out of the printer's store
  kPropose,     ///< look for the best ways up of the scan that is offered
  kOpen,        ///< list a folder of the stick
  kSettings,    ///< take what has been sliced back to its settings
  // The others are in no state's list of commands.
  kPicture,  ///< a picture of the job. Whoever may read may ask for it, as for the next two
  kMask,     ///< the mask of any layer, while what has been sliced is offered
  kReport,   ///< a part of the last print's report
  kCode,     ///< show a code on the printer's screen
  kUpload,   ///< take a scan, whose bytes come through a socket that is handed over
  kFilled,   ///< somebody has filled the tank
};
/// Those that a state's list of commands may have.
inline constexpr std::size_t kCommandCount = 13;
inline constexpr std::size_t kRequestCount = 19;

/// Whether a request changes nothing.
constexpr bool is_question(Command command) {
  return command == Command::kPicture || command == Command::kMask || command == Command::kReport;
}

/// "start", "plate-empty", ...
std::string_view to_string(Command command);
std::optional<Command> command_of(std::string_view word);

/// Whether the printer takes a command now. Of kUpload the daemon says itself why not: takes_upload() is not all of it.
bool takes(const PrinterRecord& record, Command command);

/// Whether the scan of what has been sliced can be read again: its stick is in, or it is the uploaded one.
bool scan_is_there(const PrinterRecord& record);

/// Whether a command is meant for what is at hand: it does not say what for, or it names the question that is put, or the job, as pause,
/// cancel, set, settings and propose may.
/// @param about  of RandomIds; 0: it does not say
bool is_meant(const PrinterRecord& record, Command command, std::uint64_t about);

/// Whether a command answers the question at hand as a button would, so that it must say which question, or come when a person can have
/// read it.
bool answers_question(const PrinterRecord& record, Command command);

/// Whether a scan may be uploaded now: the printer is at rest, so writing to its storage makes no mask late, and no other scan is coming.
bool takes_upload(const PrinterRecord& record);

/// "the printer is printing: it takes pause, cancel"
FixedText<200> what_it_takes(const PrinterRecord& record);

/// The button that does the same; none: the daemon does it itself (choose, set, settings, remove, propose, open, filled, code,
/// upload).
/// @pre takes()
std::optional<EventKind> button_of(Command command);

}  // namespace plumbline::firmware::inline state
