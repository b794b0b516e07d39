#pragma once
/// What people answer the daemon, by a button or a command.

#include <chrono>
#include <functional>
#include <optional>

#include "firmware/daemon/state_recorder.hpp"
#include "firmware/daemon/surroundings.hpp"
#include "firmware/state/printer_record.hpp"
#include "hal/machine.hpp"
#include "slicer/core/error.hpp"

namespace plumbline::firmware {

/// Waits while nothing is printed. The record says that somebody waits, for as long as it does.
class Answers {
 public:
  /// A press, or a command that names no question, answers the question before if it comes this soon after a new one: whoever presses start
  /// twice must not print onto a full plate.
  static constexpr nanoseconds kSettle = std::chrono::seconds(1);

  /// All must outlive it.
  Answers(Machine& machine, PrinterRecord& record, StateRecorder& recorder, Surroundings& surroundings)
      : machine_(machine), record_(record), recorder_(recorder), surroundings_(surroundings) {}

  /// Work that is done while somebody is waited for. It never waits, and returns whether it goes on. Empty: there is none.
  std::function<bool()> background;

  /// Puts a question: ask() waits for its answer, and no answer to an earlier one counts any more.
  void put() { recorder_.ask(machine_.clock.now()); }
  /// Whether the question was put less than kSettle ago.
  bool is_new() const { return machine_.clock.now() < record_.asked_at + kSettle; }

  /// Waits a fifth of a second for something to happen.
  /// @returns nothing: nothing did
  [[nodiscard]] Expected<std::optional<Event>> look();

  /// Waits for start, cancel, a stick that comes or goes, or a shutdown. Pause means "the next one". @pre put()
  [[nodiscard]] Expected<EventKind> ask(const std::function<void()>& on_next = [] {});

  bool shutdown() const { return shutdown_; }  ///< whether the system asked to end

 private:
  Machine& machine_;
  PrinterRecord& record_;
  StateRecorder& recorder_;
  Surroundings& surroundings_;
  bool shutdown_ = false;
};

}  // namespace plumbline::firmware
