#pragma once
/// A print on standard error: a live line on a terminal, elsewhere a line for each change of state and every tenth of the layers.

#include <chrono>
#include <optional>

#include "firmware/print/status/print_observer.hpp"

namespace plumbline::firmware {

class PrintLines final : public PrintObserver {
 public:
  enum class Show : std::uint8_t {
    kNothing,     ///< only looks for Ctrl-C
    kPrint,       ///< where the print is, and the checks that did not pass
    kEverything,  ///< also all checks, times, heights and resin
  };

  /// @param longest_wait  machine time after which a print that waits for its user is cancelled; none: it waits
  PrintLines(Show show, std::optional<nanoseconds> longest_wait);

  bool update(const PrintStatus& status) override;
  void checked(Check check, const CheckResult& result) override;

  /// Removes an unfinished line.
  void clear();
  /// The print was cancelled because nobody came.
  bool gave_up() const { return gave_up_; }

 private:
  using HostClock = std::chrono::steady_clock;

  Show show_;
  bool terminal_;
  std::optional<nanoseconds> longest_wait_;
  PrintState shown_ = PrintState::kIdle;
  TimePoint state_began_;
  HostClock::time_point drawn_at_;
  std::uint32_t shown_tenths_ = 0;
  bool gave_up_ = false;
};

/// "printing layer 12 of 1184, 2 h 10 min left", "paused at layer 12 of 1184: press start to go on", "homing". Layers count from 1.
FixedText<200> status_text(const PrintStatus& status);
/// Its note as a code; empty: it has none, and the text says no more than the state.
Told told_note(const PrintStatus& status);

}  // namespace plumbline::firmware
