#include "firmware/print/status/print_lines.hpp"

#include <unistd.h>

#include <algorithm>
#include <array>

#include "firmware/io/interrupt.hpp"
#include "firmware/io/progress_lines.hpp"
#include "firmware/messages/printer_code.hpp"

namespace plumbline::firmware {
namespace {

/// Between two drawings on a terminal: often enough for a person, rarely enough to cost the print little.
constexpr auto kRedraw = std::chrono::milliseconds(100);

/// By CheckOutcome.
constexpr std::array<const char*, 4> kMarks = {"-", "ok", "note", "FAILED"};

/// Why a print waits and what makes it continue; null if it does not wait.
const char* reason_to_wait(PrintState state) {
  switch (state) {
    case PrintState::kPausing:
    case PrintState::kPaused: return "press start to go on";
    case PrintState::kCoverOpen: return "the cover is open, close it";
    case PrintState::kCoolingDown: return "it waits for a temperature or a fan and goes on by itself";
    case PrintState::kFeedMe: return "the tank is nearly empty, pour in resin and press start";
    case PrintState::kIdle:
    case PrintState::kOffered:
    case PrintState::kInterrupted:
    case PrintState::kPlateInUse:
    case PrintState::kSlicing:
    case PrintState::kChecks:
    case PrintState::kHoming:
    case PrintState::kPrinting:
    case PrintState::kCancelling:
    case PrintState::kFinishing:
    case PrintState::kFinished:
    case PrintState::kCancelled:
    case PrintState::kSuspended:
    case PrintState::kFault: return nullptr;
  }
  return nullptr;
}

void add_figures(FixedText<400>& text, const PrintStatus& status) {
  text.add("  (%.3f mm, %s elapsed, %.1f ml", status.height.above_film().millimetres(),
           duration_text(status.elapsed).c_str(), status.resin_ml);
  if (status.slack) text.add(", slack %.2f s", std::chrono::duration<double>(*status.slack).count());
  text.add(")");
}

}  // namespace

FixedText<200> status_text(const PrintStatus& status) {
  FixedText<200> text;
  const std::uint32_t layer = std::min(status.layer + 1, status.layers);
  const bool waits = waits_for_start(status.state) || status.state == PrintState::kCoolingDown;
  if (waits && !status.question.empty()) {
    text.add("paused at layer %u of %u: %.*s", layer, status.layers, static_cast<int>(status.question.size()),
             status.question.data());
  } else if (status.note == PrintNote::kCoverFirst) {
    text.add("close the cover: the plate does not move while it is open");
  } else if (const char* const reason = reason_to_wait(status.state)) {
    text.add("paused at layer %u of %u: %s", layer, status.layers, reason);
  } else if (status.state == PrintState::kPrinting) {
    text.add("printing layer %u of %u, %s left", layer, status.layers, duration_text(status.remaining).c_str());
  } else {
    const auto state = to_string(status.state);
    text.add("%.*s", static_cast<int>(state.size()), state.data());
  }
  if (status.note == PrintNote::kPauseTaken) text.add("; it pauses after this layer");
  return text;
}

Told told_note(const PrintStatus& status) {
  switch (status.note) {
    case PrintNote::kNone: return {};
    case PrintNote::kPauseTaken: return PrinterCode::kPauseTaken;
    case PrintNote::kCoverFirst: return PrinterCode::kCoverFirst;
  }
  return {};
}

PrintLines::PrintLines(Show show, std::optional<nanoseconds> longest_wait)
    : show_(show), terminal_(::isatty(STDERR_FILENO) == 1), longest_wait_(longest_wait) {}

bool PrintLines::update(const PrintStatus& status) {
  const bool new_state = status.state != shown_;
  if (new_state) state_began_ = status.now;
  shown_ = status.state;
  if (longest_wait_ && is_pause(status.state) && status.now - state_began_ > *longest_wait_) gave_up_ = true;
  if (show_ != Show::kNothing) {
    const std::uint32_t tenths = status.layers == 0 ? 0 : status.layer * 10 / status.layers;
    const auto now = HostClock::now();
    const bool due = terminal_ ? now - drawn_at_ > kRedraw : tenths != shown_tenths_;
    if (new_state || due) {
      FixedText<400> text;
      text.add("%s", status_text(status).c_str());
      if (show_ == Show::kEverything) add_figures(text, status);
      if (terminal_) erase_line();
      if (terminal_ && !new_state) {
        draw_line(text.view());
      } else {
        write_line(text.view());
      }
      drawn_at_ = now;
      shown_tenths_ = tenths;
    }
  }
  return !interrupted() && !gave_up_;
}

void PrintLines::checked(Check check, const CheckResult& result) {
  if (show_ == Show::kNothing || (show_ == Show::kPrint && result.outcome == CheckOutcome::kPassed)) return;
  FixedText<320> line;
  const auto name = to_string(check);
  line.add("  check %-13.*s %-6s %s", static_cast<int>(name.size()), name.data(),
           kMarks[static_cast<std::size_t>(result.outcome)], result.detail.c_str());
  write_line(line.view());
}

void PrintLines::clear() {
  if (show_ != Show::kNothing && terminal_) erase_line();
}

}  // namespace plumbline::firmware
