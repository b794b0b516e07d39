#include "firmware/io/text/fixed_text.hpp"
#include "firmware/settings/setting_words.hpp"
#include "firmware/setup/bench.hpp"
#include "firmware/setup/panel_look.hpp"

namespace plumbline::firmware {
namespace {

constexpr int kMostLooks = 10;

Expected<CornerSquares> corners_in(const std::string& answer) {
  CornerSquares seen{};
  std::size_t count = 0;
  for (const char c : answer) {
    if (c == ' ' || c == ',') continue;
    if (c < '1' || c > '4' || count == seen.size()) {
      return fail(ErrorCode::kBadSetting, "answer with four numbers from 1 to 4, such as 2 1 4 3, or with light");
    }
    seen[count++] = static_cast<unsigned>(c - '0');
  }
  if (count == seen.size()) return seen;
  return fail(ErrorCode::kBadSetting, "answer with four numbers, one for each corner");
}

std::string text_of(const CornerSquares& squares) {
  FixedText<64> text;
  for (const unsigned one : squares) text.add("%s%u", text.view().empty() ? "" : " ", one);
  return text.c_str();
}

/// Takes the layout over, and swaps what belongs to x and y if the panel is turned.
Status take_layout(BoardDraft& draft, const PanelLayout& layout) {
  constexpr std::array kMirrors = {"none", "x", "y"};
  const BoardFile before = draft.values();
  const auto put = [&](const char* key, const std::string& value, const char* source) {
    return draft.set("panel", key, value, source);
  };
  if ((layout.rotation_deg + before.machine->panel.rotation_deg) % 180 != 0) {
    constexpr const char* kSwapped = "swapped: the panel is turned";
    PLUMBLINE_TRY(put("columns", std::to_string(before.rows), kSwapped));
    PLUMBLINE_TRY(put("rows", std::to_string(before.columns), kSwapped));
    PLUMBLINE_TRY(put("pixel_pitch_x_mm", number(before.pixel_pitch_y_mm), kSwapped));
    PLUMBLINE_TRY(put("pixel_pitch_y_mm", number(before.pixel_pitch_x_mm), kSwapped));
  }
  PLUMBLINE_TRY(put("rotation_deg", std::to_string(layout.rotation_deg), kMeasured));
  return put("mirror", kMirrors[static_cast<std::size_t>(layout.mirror)], kMeasured);
}

}  // namespace

Status measure_panel(Dialogue& dialogue, BoardDraft& draft, const OpenMachine& open) {
  BoardFile plain = draft.values();
  PanelLayout& sent = plain.machine->panel;
  sent.columns = plain.columns;
  sent.rows = plain.rows;
  PLUMBLINE_TRY(sent.check());
  // The same picture without rotation or mirror, so that the mode stays.
  sent = {sent.picture_width(), sent.mode_height(), 0, PanelLayout::Mirror::kNone, sent.rgb};
  auto bench = Bench::open(dialogue, plain, open);
  PLUMBLINE_TRY(bench);
  PLUMBLINE_TRY((*bench)->show(draw_corners));
  dialogue.say(
      "\nThe panel shows small squares now: 1, 2, 3 and 4 of them, one number in each corner. The lamp is dark.\n"
      "Stand before the printer, take the tank out, and look down on the panel. A torch below or beside it helps.");
  if (Witness* const witness = (*bench)->witness()) {
    dialogue.say("  (simulated: you see " + text_of(squares_in(witness->panel_from_above().image())) + ")");
  }
  std::optional<PanelLayout> layout;
  for (int looks = 0; !layout; ++looks) {
    if (looks == kMostLooks) return fail(ErrorCode::kCancelled, "lit %d times without an answer", kMostLooks);
    bool light = false;
    const Question question{"look.corners", "squares in the corners: back left, back right, front right, front left",
                            "four numbers such as 2 1 4 3; or light, to light the lamp for a moment", ""};
    const auto asked = dialogue.ask(question, [&](const std::string& answer) -> Status {
      light = answer == "light";
      if (light) return {};
      const auto seen = corners_in(answer);
      PLUMBLINE_TRY(seen);
      const auto found = layout_for(sent, *seen);
      PLUMBLINE_TRY(found);
      layout = *found;
      return {};
    });
    PLUMBLINE_TRY(asked);
    if (light) PLUMBLINE_TRY((*bench)->flash(kFlash, "look.light", " to see the squares through the cover"));
  }
  PLUMBLINE_TRY(take_layout(draft, *layout));
  dialogue.say("  mirror = " + draft.value("panel", "mirror") +
               ", rotation_deg = " + draft.value("panel", "rotation_deg") + ", " + draft.value("panel", "columns") +
               " x " + draft.value("panel", "rows") + " pixels");
  return {};
}

}  // namespace plumbline::firmware
