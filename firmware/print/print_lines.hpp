#pragma once
/// A print on the terminal: a live line, the checks as they pass, a line for each change of state.

#include <chrono>
#include <optional>

#include "firmware/print/print_job.hpp"

namespace plumbline {

class PrintLines final : public PrintObserver {
 public:
  /// @param show          false: only listens for Ctrl-C
  /// @param longest_wait  machine time after which a print that waits for its user is cancelled; none: it waits
  PrintLines(bool show, std::optional<nanoseconds> longest_wait);

  bool update(const PrintStatus& status) override;
  void checked(Check check, const CheckResult& result) override;

  /// Takes an unfinished line away.
  void clear();
  /// Nobody came.
  bool gave_up() const { return gave_up_; }

 private:
  using HostClock = std::chrono::steady_clock;

  bool show_;
  bool terminal_;
  std::optional<nanoseconds> longest_wait_;
  PrintState shown_ = PrintState::kIdle;
  TimePoint state_began_;
  HostClock::time_point drawn_at_;
  std::uint32_t told_tenths_ = 0;
  bool gave_up_ = false;
};

/// "1:02:03"
FixedText<24> clock_text(nanoseconds time);

}  // namespace plumbline
