#include <algorithm>
#include <array>

#include "firmware/setup/setup.hpp"
#include "hal/wiring.hpp"
#include "slicer/core/words/printable_text.hpp"

namespace plumbline::firmware {
namespace {

constexpr const char* kAsked = "asked by plumbline setup";

struct Key {
  const char* table;
  const char* key;
  const char* use;
  const char* otherwise = "";  ///< what a file without the key says
};

/// In an order in which no answer is checked against one that is still to come.
constexpr std::array<Key, 21> kKeys = {{
    {"printer", "language", "language of the printer's screen", "en"},
    {"printer", "page",
     "who may open the printer's page in a browser. off: nobody; local: this machine; network: whoever is paired",
     "off"},
    {"panel", "columns",
     "pixels of the panel along x, as its data sheet counts them. The look at the panel may swap x and y"},
    {"panel", "rows", "pixels of the panel along y"},
    {"panel", "packing",
     "how pixels go over the cable. rgb: a monochrome panel that takes three pixels as one, as most do"},
    {"panel", "pixel_pitch_x_mm", "distance between pixels along x: width of the picture in mm / columns"},
    {"panel", "pixel_pitch_y_mm", "distance between pixels along y: height of the picture in mm / rows"},
    {"z_stage", "travel_mm", "height of the tallest print"},
    {"z_stage", "end_stop_height_mm", "height of the plate above the film when the end stop at the top closes"},
    {"z_stage", "rotation_distance_mm", "travel for one turn of the motor: the screw's lead. It is measured below"},
    {"z_stage", "full_steps_per_rotation", "of the motor: 200 for 1.8 degrees a step"},
    {"z_stage", "microsteps", "pulses to the driver for one full step, as its jumpers say. They are measured below"},
    {"z_stage", "max_speed_mm_min", "fastest move"},
    {"z_stage", "homing_speed_mm_min", "speed of the slow approach to the end stop"},
    {"lamp", "power_mw_cm2", "light at the film through a white mask. It is measured below"},
    {"lamp", "max_exposure_s", "longest single exposure"},
    {"cover", "switch", "whether the cover has a switch. Without one the lamp can blind whoever opens it"},
    {"tank", "volume_ml", "resin in a full tank"},
    {"memory", "arena_mib", "memory for the slicer: half of the board's"},
    {"print", "profile", "file in profiles/ for resin and print"},
    {"print", "start",
     "what begins a print. on_request: somebody presses start; after_preview: somebody presses start again once the "
     "size and time are "
     "known; on_stick: a stick that is plugged in, for test rigs",
     "on_request"},
}};

/// What a line says when it is on, where that is not plain.
const char* meaning_of_on(std::string_view table) {
  if (table == "lamp_line") return ". A resistor must keep the lamp off while nothing drives it";
  if (table == "cover_line") return ": on is open";
  if (table == "direction_line") return ": on is up. It is measured below";
  if (table == "end_stop_line" || table.ends_with("_button")) return ": on is pressed";
  return "";
}

}  // namespace

std::string to_text(std::span<const BoardPart> parts) {
  if (parts.empty()) return "This board shows no devices that a board file can name.";
  std::string text = "What this board has:";
  for (const BoardPart& part : parts) {
    std::string line = part.kind;
    line.resize(std::max<std::size_t>(line.size() + 1, 14), ' ');
    line += part.answer;
    line.resize(std::max<std::size_t>(line.size() + 1, 44), ' ');
    text += "\n  " + std::string(PrintableText(line + part.detail).view());
  }
  return text;
}

Status ask_about_printer(Dialogue& dialogue, BoardDraft& draft, const std::string& name) {
  PLUMBLINE_TRY(draft.set("printer", "name", name, "equals the file's name"));
  const auto ask_key = [&](const Key& one) {
    const std::string full = std::string(one.table) + "." + one.key;
    const std::string now = draft.value(one.table, one.key);
    const Question question{full, one.use, draft.allowed_for(one.table, one.key), now.empty() ? one.otherwise : now};
    return dialogue.ask(question, [&](const std::string& answer) -> Status {
      // What is taken over is checked, too: another answer may not go with it.
      const bool same = answer == draft.value(one.table, one.key);
      PLUMBLINE_TRY(draft.set(one.table, one.key, answer, same ? "" : kAsked));
      if (one.key != std::string_view("profile")) return Status();
      const auto profile = read_print_profile(answer, draft.values().path);
      return profile ? Status() : Status(tl::unexpected<Error>(profile.error()));
    });
  };
  for (const Key& one : kKeys) PLUMBLINE_TRY(ask_key(one));
  const Question screen{
      "screen", "a small display for people",
      "connector and size in pixels, such as HDMI-A-1 800x480; if it needs them, its rotation in degrees, 16-bit, and "
      "the path of its touch panel; or none",
      draft.screen()};
  PLUMBLINE_TRY(dialogue.ask(screen, [&](const std::string& answer) {
    return answer == draft.screen() ? Status() : draft.set_screen(answer, kAsked);
  }));
  if (draft.values().machine->simulated) return {};
  PLUMBLINE_TRY(ask_key({"display", "connector", "the panel's connector, such as HDMI-A-1"}));
  Status asked;
  Wiring wiring;
  for_each_line(wiring, [&](const LineRole& role, LineSettings& /*line*/) {
    if (!asked) return;
    const bool needed = role.required || (role.table == "cover_line" && draft.value("cover", "switch") == "true");
    std::string fallback = draft.line(role.table);
    if (needed && fallback == "none") fallback.clear();
    const Question question{
        std::string(role.table), "the line of " + std::string(role.use) + meaning_of_on(role.table),
        std::string("a name, or chip and number; low if a low voltage means on; pull-up or pull-down "
                    "if it needs one") +
            (needed ? "" : "; or none"),
        fallback};
    asked = dialogue.ask(question, [&](const std::string& answer) -> Status {
      if (answer == draft.line(role.table)) return {};
      if (needed && answer == "none") return fail(ErrorCode::kBadSetting, "no printer works without it");
      return draft.set_line(role.table, answer, kAsked);
    });
  });
  PLUMBLINE_TRY(asked);
  for (const auto& [table, use] : {std::pair{"lamp_sensor", "temperature of the LEDs' heat sink"},
                                   {"resin_sensor", "temperature of the tank"},
                                   {"board_sensor", "temperature of the processor"}}) {
    const Question question{table, use, "hwmon NAME, hwmon NAME CHANNEL, zone TYPE or file PATH", draft.sensor(table)};
    PLUMBLINE_TRY(dialogue.ask(question, [&, table = table](const std::string& answer) {
      return answer == draft.sensor(table) ? Status() : draft.set_sensor(table, answer, kAsked);
    }));
  }
  for (const auto& [table, use] : {std::pair{"lamp_fan", "cools the LEDs"}, {"chamber_fan", "extracts vapour"}}) {
    const Question question{table, use, "hwmon NAME CHANNEL, pwm CHIP CHANNEL, or none", draft.fan(table)};
    PLUMBLINE_TRY(dialogue.ask(question, [&, table = table](const std::string& answer) {
      return answer == draft.fan(table) ? Status() : draft.set_fan(table, answer, kAsked);
    }));
  }
  return {};
}

}  // namespace plumbline::firmware
