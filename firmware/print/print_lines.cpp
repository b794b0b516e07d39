#include "firmware/print/print_lines.hpp"

#include <unistd.h>

#include "firmware/io/interrupt.hpp"
#include "firmware/io/progress_lines.hpp"

namespace plumbline {
namespace {

constexpr const char* kEraseLine = "\r\033[K";

bool waits_for_user(PrintState state) {
  return state == PrintState::kPaused || state == PrintState::kCoverOpen || state == PrintState::kFeedMe ||
         state == PrintState::kCoolingDown;
}

const char* word_of(CheckOutcome outcome) {
  switch (outcome) {
    case CheckOutcome::kNotReached: return "-";
    case CheckOutcome::kPassed: return "ok";
    case CheckOutcome::kWarned: return "note";
    case CheckOutcome::kFailed: return "FAILED";
  }
  return "?";
}

FixedText<240> line_of(const PrintStatus& status) {
  FixedText<240> line;
  const auto state = to_string(status.state);
  line.add("%-12.*s layer %5u/%u %8.3f mm  %s elapsed  %s left", static_cast<int>(state.size()), state.data(),
           status.layer, status.layers, status.height.above_film().millimetres(), clock_text(status.elapsed).c_str(),
           clock_text(status.remaining).c_str());
  if (status.slack) line.add("  slack %.2f s", std::chrono::duration<double>(*status.slack).count());
  line.add("  %.1f ml", status.resin_ml);
  return line;
}

}  // namespace

FixedText<24> clock_text(nanoseconds time) {
  const auto seconds = std::chrono::duration_cast<std::chrono::seconds>(time).count();
  FixedText<24> text;
  text.add("%lld:%02d:%02d", static_cast<long long>(seconds / 3600), static_cast<int>(seconds / 60 % 60),
           static_cast<int>(seconds % 60));
  return text;
}

PrintLines::PrintLines(bool show, std::optional<nanoseconds> longest_wait)
    : show_(show), terminal_(::isatty(STDERR_FILENO) == 1), longest_wait_(longest_wait) {}

bool PrintLines::update(const PrintStatus& status) {
  const bool new_state = status.state != shown_;
  if (new_state) state_began_ = status.now;
  shown_ = status.state;
  if (longest_wait_ && waits_for_user(status.state) && status.now - state_began_ > *longest_wait_) gave_up_ = true;
  if (show_) {
    // On a terminal one line that moves; elsewhere the states, and every tenth of the layers.
    const std::uint32_t tenths = status.layers == 0 ? 0 : status.layer * 10 / status.layers;
    const auto now = HostClock::now();
    const bool due = terminal_ ? now - drawn_at_ > std::chrono::milliseconds(100) : tenths != told_tenths_;
    if (new_state || due) {
      FixedText<320> text;
      text.add("%s%s%s", terminal_ ? kEraseLine : "", line_of(status).c_str(), terminal_ && !new_state ? "" : "\n");
      write_to_stderr(text.view());
      drawn_at_ = now;
      told_tenths_ = tenths;
    }
  }
  return !interrupted() && !gave_up_;
}

void PrintLines::checked(Check check, const CheckResult& result) {
  if (!show_) return;
  FixedText<320> line;
  const auto name = to_string(check);
  line.add("  check %-13.*s %-6s %s\n", static_cast<int>(name.size()), name.data(), word_of(result.outcome),
           result.detail.c_str());
  write_to_stderr(line.view());
}

void PrintLines::clear() {
  if (show_ && terminal_) write_to_stderr(kEraseLine);
}

}  // namespace plumbline
