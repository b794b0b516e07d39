#include "firmware/screen/light_card.hpp"

#include "firmware/print/status/print_state.hpp"
#include "firmware/screen/screen_parts.hpp"

namespace plumbline::firmware::inline screen {
namespace {

/// By PanelLight.
constexpr std::array kNames = {Words::kLightReady, Words::kLightPrinting, Words::kLightAttention, Words::kLightFault};
constexpr std::array kInks = {ink::kGood, ink::kText, ink::kAttention, ink::kFault};
static_assert(kNames.size() == kPanelLightCount);
constexpr std::size_t kColumnCount = kPanelLightCount + 1;  // the last one is the buzzer's
/// Where the columns begin and the last one ends, percent of the width: as their names need it.
constexpr std::array<int, kColumnCount + 1> kColumnsBegin = {0, 16, 37, 60, 79, 100};

Words word_for(LightState light) {
  switch (light) {
    case LightState::kOff: return Words::kLightOff;
    case LightState::kOn: return Words::kLightOn;
    case LightState::kBlinking: return Words::kLightBlinks;
  }
  return Words::kLightOff;
}

/// The room of a column in a row.
PixelBox column_of(const PixelBox& row, std::size_t column) {
  const int left = row.width * kColumnsBegin[column] / 100, right = row.width * kColumnsBegin[column + 1] / 100;
  return {row.x + left, row.y, right - left, row.height};
}

void draw_pattern(const Sheet& sheet, const PixelBox& row, PrintState state) {
  const auto put = [&](std::size_t column, Words word, Colour ink) {
    sheet.page.line(column_of(row, column), sheet.say(word), {sheet.look().plain, ink, Align::kCentre});
  };
  for (std::size_t i = 0; i < kPanelLightCount; ++i) {
    const LightState light = light_for(static_cast<PanelLight>(i), state);
    put(i, word_for(light), light == LightState::kOff ? ink::kPale : kInks[i]);
  }
  const bool calls = calls_the_user(state);
  put(kColumnCount - 1, calls ? Words::kBuzzes : Words::kLightOff, calls ? ink::kText : ink::kPale);
}

}  // namespace

bool same_lights(PrintState a, PrintState b) {
  for (std::size_t i = 0; i < kPanelLightCount; ++i) {
    const auto light = static_cast<PanelLight>(i);
    if (light_for(light, a) != light_for(light, b)) return false;
  }
  return calls_the_user(a) == calls_the_user(b);
}

std::size_t light_pattern_of(PrintState state) {
  for (std::size_t i = 0; i < kLightPatternCount; ++i) {
    if (same_lights(kLightPatterns[i].state, state)) return i;
  }
  return 0;
}

void draw_light_card(const Sheet& sheet) {
  draw_title(sheet, sheet.say(Words::kLightCard));
  const PixelBox body = sheet.body();
  const int line = sheet.look().plain.line_height(), height = row_height(sheet);
  const PixelBox head = body.top_rows(line);
  for (std::size_t i = 0; i < kColumnCount; ++i) {
    const Words name = i < kPanelLightCount ? kNames[i] : Words::kBuzzer;
    sheet.page.line(column_of(head, i), sheet.say(name), {sheet.look().plain, ink::kPale, Align::kCentre});
  }
  const PixelBox list = body.from_row(line);
  const int meaning = 2 * line + sheet.px(2);
  const ListPart part = shown_part(list.height - meaning, row_height(sheet), kLightPatternCount, sheet.view.pattern);
  for (std::size_t i = 0; i < part.count; ++i) {
    const std::size_t pattern = part.first + i;
    const PixelBox row{list.x, list.y + static_cast<int>(i) * height, list.width, height};
    if (pattern == sheet.view.pattern) sheet.canvas().fill(row, ink::kChosen);
    draw_pattern(sheet, row, kLightPatterns[pattern].state);
  }
  const PixelBox rest = body.from_row(body.height - 2 * line);
  sheet.page.paragraph(rest, sheet.say(kLightPatterns[sheet.view.pattern].meaning), sheet.bold());
}

}  // namespace plumbline::firmware::inline screen
