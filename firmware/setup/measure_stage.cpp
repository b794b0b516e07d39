#include <cmath>

#include "firmware/settings/setting_words.hpp"
#include "firmware/setup/bench.hpp"
#include "firmware/setup/stage_trial.hpp"

namespace plumbline::firmware {
namespace {

constexpr int kMostJogs = 8;
/// The first jog is short, since steps may be sixteen times as long as they should be.
constexpr Distance kFirstJog = 1_mm;
constexpr Distance kCheckJog = 5_mm;
constexpr double kSureMm = 2;

Status take_drive(BoardDraft& draft, const Drive& drive) {
  const Drive before{draft.values().machine->rotation_distance_mm, draft.values().machine->full_steps_per_rotation,
                     draft.values().machine->microsteps, draft.values().machine->wiring.direction.active_low};
  if (drive.rotation_distance_mm != before.rotation_distance_mm) {
    PLUMBLINE_TRY(draft.set("z_stage", "rotation_distance_mm", number(drive.rotation_distance_mm), kMeasured));
  }
  if (drive.microsteps != before.microsteps) {
    PLUMBLINE_TRY(draft.set("z_stage", "microsteps", std::to_string(drive.microsteps), kMeasured));
  }
  if (drive.direction_active_low == before.direction_active_low) return {};
  return draft.set("direction_line", "active", drive.direction_active_low ? "low" : "high", kMeasured);
}

std::string up_text(const Drive& drive) {
  return std::string("a ") + (drive.direction_active_low ? "low" : "high") + " voltage of [direction_line] is up";
}

Drive drive_of(const MachineFile& machine) {
  return {machine.rotation_distance_mm, machine.full_steps_per_rotation, machine.microsteps,
          machine.wiring.direction.active_low};
}

/// Asks whether the end stop reads right, and turns its line round if not.
Status check_end_stop(Dialogue& dialogue, BoardDraft& draft, const OpenMachine& open) {
  const auto bench = Bench::open(dialogue, draft.values(), open);
  PLUMBLINE_TRY(bench);
  const std::string state = (*bench)->machine().stage.end_stop_pressed() ? "pressed" : "not pressed";
  const auto right =
      dialogue.ask_yes({"end_stop.right", "the printer sees the end stop as " + state + ". Is that so?", "", "yes"});
  PLUMBLINE_TRY(right);
  if (*right) return {};
  const bool low = draft.values().machine->wiring.end_stop.active_low;
  return draft.set("end_stop_line", "active", low ? "high" : "low", kMeasured);
}

struct Jog {
  double moved_mm = 0;  ///< as the user measured it; below 0: down
  bool arrived = true;  ///< else the end stop ended it
};

/// Moves the plate up, and asks how far it went.
/// @param number_of_jog  from 1
Expected<Jog> jog_up(Dialogue& dialogue, BoardDraft& draft, const OpenMachine& open, Distance way, int number_of_jog) {
  const auto bench = Bench::open(dialogue, draft.values(), open);
  PLUMBLINE_TRY(bench);
  ZStage& stage = (*bench)->machine().stage;
  Witness* const witness = (*bench)->witness();
  const Distance before = witness != nullptr ? witness->plate_height() : Distance();
  dialogue.say("\n  Moving up by " + number(way.millimetres()) + " mm.");
  auto motion = stage.begin_jog(way);
  PLUMBLINE_TRY(motion);
  PLUMBLINE_TRY(wait_for(*motion, (*bench)->machine()));  // the motion stops when it goes out of scope
  const auto report = motion->finish();
  PLUMBLINE_TRY(report);
  if (!report->arrived) dialogue.say("  The end stop closed, so it ended early. Measure as far as it went.");
  if (witness != nullptr) {
    dialogue.say("  (simulated: you measure " + number((witness->plate_height() - before).millimetres()) + " mm)");
  }
  double moved_mm = 0;
  const Question question{"move." + std::to_string(number_of_jog),
                          "how far did the plate move? Measure it with a caliper",
                          "mm; below 0 if it went down, 0 if nothing could be seen", ""};
  const auto asked = dialogue.ask(question, [&](const std::string& answer) -> Status {
    const auto value = number_in(answer, -1000, 1000, "mm");
    PLUMBLINE_TRY(value);
    moved_mm = *value;
    if (moved_mm == 0) return {};
    const auto drive = drive_for(drive_of(*draft.values().machine), way, moved_mm);
    PLUMBLINE_TRY(drive);
    return {};
  });
  PLUMBLINE_TRY(asked);
  return Jog{moved_mm, report->arrived};
}

}  // namespace

Status measure_stage(Dialogue& dialogue, BoardDraft& draft, const OpenMachine& open) {
  dialogue.say(
      "\nThe plate will move by up to 10 mm, slowly, and nobody knows yet which way. Take the tank out, turn the screw "
      "by hand\n"
      "until the plate has 20 mm free above and below, and be ready to press the end stop, stop, or Ctrl-C: each ends "
      "the move.");
  const auto ready = dialogue.ask_yes({"move.ready", "may the plate move?", "", ""});
  PLUMBLINE_TRY(ready);
  if (!*ready) {
    dialogue.say("  Left out: steps and direction stay as they are.");
    return {};
  }
  PLUMBLINE_TRY(check_end_stop(dialogue, draft, open));
  Distance next = kFirstJog;
  for (int jog = 1; jog <= kMostJogs; ++jog) {
    const auto jogged = jog_up(dialogue, draft, open, next, jog);
    PLUMBLINE_TRY(jogged);
    const double moved_mm = jogged->moved_mm;
    if (!jogged->arrived) {
      dialogue.say("  Turn the screw by hand until the end stop is free.");
      continue;
    }
    // A caliper's tenth is too much of a short way to conclude from it.
    if (std::abs(moved_mm) < kSureMm && next < ZStage::kLongestJog) {
      next = next == kFirstJog ? kCheckJog : ZStage::kLongestJog;
      if (moved_mm < 0) {  // a longer jog must not go down
        Drive turned = drive_of(*draft.values().machine);
        turned.direction_active_low = !turned.direction_active_low;
        PLUMBLINE_TRY(take_drive(draft, turned));
      }
      dialogue.say("  Too short a way to tell. Once more, a longer one.");
      continue;
    }
    if (moved_mm == 0) {
      return fail(
          ErrorCode::kBadSetting,
          "the plate does not move:\tcheck the driver's supply, [step_line] and [enable_line], then run setup again");
    }
    const Drive now = drive_of(*draft.values().machine);
    const auto drive = drive_for(now, next, moved_mm);
    PLUMBLINE_TRY(drive);
    const bool agrees = std::abs(moved_mm / next.millimetres() - 1) <= kSameTravel;
    if (agrees && next >= kCheckJog) {
      dialogue.say("  That agrees: " + number(now.step_mm() * 1000) + " um a step, " + up_text(now) + ".");
      return {};
    }
    PLUMBLINE_TRY(take_drive(draft, *drive));
    dialogue.say("  So it takes " + number(drive->microsteps) + " microsteps and " +
                 number(drive->rotation_distance_mm) + " mm a turn, and " + up_text(*drive) +
                 ". Once more, to check it.");
    next = kCheckJog;
  }
  return fail(ErrorCode::kBadSetting,
              "%d moves and no two agree:\tcheck that screw and motor don't slip, then run setup again", kMostJogs);
}

}  // namespace plumbline::firmware
