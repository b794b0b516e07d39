#pragma once
/// What people answer the daemon, by a button or a command.

#include <functional>
#include <optional>

#include "firmware/daemon/daemon_observer.hpp"
#include "firmware/state/printer_record.hpp"
#include "hal/machine.hpp"
#include "slicer/core/error.hpp"

namespace plumbline {

/// Waits while nothing is printed. The record says that somebody waits, for as long as it does.
class Answers {
 public:
  /// All must outlive it.
  Answers(Machine& machine, PrinterRecord& record, DaemonObserver& observer)
      : machine_(machine), record_(record), observer_(observer) {}

  /// Work that is done while somebody is waited for. It never waits, and returns whether it goes on. Empty: there is none.
  std::function<bool()> background;

  /// Waits a fifth of a second for something to happen.
  /// @returns nothing: nothing did
  [[nodiscard]] Expected<std::optional<Event>> look();

  /// Waits for start, cancel, a stick that comes or goes, or a shutdown. Pause means "the next one".
  [[nodiscard]] Expected<EventKind> ask(const std::function<void()>& on_next = [] {});

  /// The event that look() or ask() is about to get is a command's, which names the question that it answers.
  void answer_by_command() { by_command_ = true; }

  bool shutdown() const { return shutdown_; }  ///< whether the system asked to end

 private:
  Machine& machine_;
  PrinterRecord& record_;
  DaemonObserver& observer_;
  bool by_command_ = false;
  bool shutdown_ = false;
};

}  // namespace plumbline
