#include "firmware/setup/bench.hpp"

#include <algorithm>
#include <cstdlib>

#include "firmware/settings/setting_words.hpp"

namespace plumbline::firmware {
namespace {

/// Whether somebody wants to stop; for Dialogue::watch.
Status look_for_stop(Machine& machine) {
  for (;;) {
    const auto event = machine.events.next_event(machine.clock.now());
    PLUMBLINE_TRY(event);
    if (!*event) return {};
    PLUMBLINE_TRY(ended_by(**event));
  }
}

}  // namespace

Expected<double> number_in(std::string text, double least, double most, const char* unit) {
  std::replace(text.begin(), text.end(), ',', '.');
  char* end = nullptr;
  const double value = std::strtod(text.c_str(), &end);
  if (end == text.c_str() || *end != '\0' || !(value >= least && value <= most)) {
    return fail(ErrorCode::kBadSetting, "allowed is a number from %s to %s %s", number(least).c_str(),
                number(most).c_str(), unit);
  }
  return value;
}

Status ended_by(const Event& event) {
  if (event.kind != EventKind::kCancelPressed && event.kind != EventKind::kPausePressed &&
      event.kind != EventKind::kShutdownRequested) {
    return {};
  }
  return fail(ErrorCode::kCancelled, "stopped: %s. The lamp is dark, the plate stands, and nothing was written",
              std::string(to_string(event.kind)).c_str());
}

Expected<std::unique_ptr<Bench>> Bench::open(Dialogue& dialogue, const BoardFile& board, const OpenMachine& open) {
  auto back_end = open(board);
  PLUMBLINE_TRY(back_end);
  return std::unique_ptr<Bench>(new Bench(dialogue, std::move(*back_end)));
}

Bench::Bench(Dialogue& dialogue, std::unique_ptr<BackEnd> back_end)
    : dialogue_(dialogue), back_end_(std::move(back_end)) {
  dialogue_.watch = [this] { return look_for_stop(machine()); };
}

Bench::~Bench() {
  dialogue_.watch = nullptr;
  machine().lamp.turn_off();
  static_cast<void>(machine().mask.blank());
}

Expected<bool> Bench::flash(nanoseconds time, const std::string& name, const std::string& what) {
  const auto most = std::min(time, machine().lamp.limits().longest_exposure);
  const double seconds = std::chrono::duration<double>(most).count();
  const auto yes = dialogue_.ask_yes({name,
                                      "light the lamp for " + number(seconds) + " s" + what +
                                          "? Close the cover and look away: UV hurts eyes and skin",
                                      "", ""});
  PLUMBLINE_TRY(yes);
  if (!*yes) return false;
  auto exposure = machine().lamp.begin_exposure(most);
  if (!exposure && exposure.error().code() == ErrorCode::kCoverOpen) {
    dialogue_.say("  The cover is open, so the lamp stayed dark.");
    return false;
  }
  PLUMBLINE_TRY(exposure);
  const Status waited = wait_for(*exposure, machine());
  // Ends the light. Nobody is told that the lamp is dark before it is.
  const auto report = exposure->finish();
  PLUMBLINE_TRY(report);
  PLUMBLINE_TRY(waited);
  dialogue_.say("  The lamp is dark again.");
  return report->end == ExposureEnd::kTimeUp;
}

Status Bench::show(const std::function<void(BitImage)>& draw) {
  auto mask = machine().mask.lend();
  PLUMBLINE_TRY(mask);
  draw(mask->image());
  return machine().mask.present(std::move(*mask));
}

}  // namespace plumbline::firmware
