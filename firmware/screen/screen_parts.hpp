#pragma once
/// What the screens are put together from.

#include <array>
#include <chrono>
#include <optional>
#include <string_view>

#include "firmware/canvas/qr_code.hpp"
#include "firmware/io/text/fixed_text.hpp"
#include "firmware/messages/catalogue.hpp"
#include "firmware/messages/told_text.hpp"
#include "firmware/screen/page.hpp"
#include "firmware/screen/screen_view.hpp"

namespace plumbline::firmware::inline screen {

/// An English sentence of the printer as the screen shows it: with a capital if it begins with an article, since what begins
/// with a name keeps it, and with the signs of the buttons instead of their names.
ToldText as_shown(std::string_view english);

/// One screen while it is drawn.
struct Sheet {
  Page& page;
  const PrinterRecord& record;
  const ScreenView& view;
  Language language;
  const PreviewPicture* kept_preview;  ///< nullptr: there is none
  const QrCode* address_code;          ///< of the record's address; nullptr: there is none

  std::string_view say(Words which) const { return words(which, language); }
  /// @param english  the sentence beside it
  ToldText say(const Told& told, std::string_view english) const {
    return language == Language::kEnglish ? as_shown(english) : worded(told, language, english);
  }
  /// The table's texts must fit.
  Fit fit_of(const Told& told) const { return told_words(told.code, language) ? Fit::kMust : Fit::kMayCut; }
  const Look& look() const { return page.look(); }
  Canvas& canvas() const { return page.canvas(); }
  int px(int at_320) const { return page.look().px(at_320); }
  PixelBox body() const;

  TextStyle plain(Colour ink = ink::kText, Fit fit = Fit::kMust) const {
    return {look().plain, ink, Align::kLeft, fit};
  }
  TextStyle bold(Colour ink = ink::kText, Fit fit = Fit::kMust) const { return {look().bold, ink, Align::kLeft, fit}; }
  TextStyle large(Colour ink = ink::kText) const { return {look().large, ink}; }
};

/// What is between the title and the buttons of a screen, without margins.
PixelBox body_of(const Look& look, const PixelBox& all);

/// A row's height in lists.
int row_height(const Sheet& sheet);
/// A row of a list, the chosen one on a bar.
/// @returns the room for its text
PixelBox draw_row(const Sheet& sheet, const PixelBox& box, bool chosen);
/// Two texts of a row, one at either end.
void draw_pair(const Sheet& sheet, const PixelBox& room, std::string_view left, std::string_view right,
               const TextStyle& style);
/// Rows of a list that fit a height, if each has that of `row`, so that the one at hand is among them.
struct ListPart {
  std::size_t first = 0, count = 0;
};
ListPart shown_part(int height, int row, std::size_t rows, std::size_t at);

/// The ground and the title's bar. A code that somebody is to type into a browser takes the title's place.
/// @param bar  its colour; the text is dark on bright ones
void draw_title(const Sheet& sheet, std::string_view title, Colour bar = ink::kBar, Fit fit = Fit::kMust);
void draw_buttons(const Sheet& sheet);
/// A bar that is full at 1.
void draw_bar(const Sheet& sheet, const PixelBox& box, double fraction);
/// A picture as large as the box allows.
/// @param picture  nullptr: words say that there is none
template <class Picture>
void draw_picture(const Sheet& sheet, const PixelBox& box, const Picture* picture) {
  if (picture == nullptr || !picture->there()) {
    sheet.page.line(box, sheet.say(Words::kNoPicture), {sheet.look().plain, ink::kPale, Align::kCentre});
    return;
  }
  const auto columns = static_cast<int>(picture->columns), rows = static_cast<int>(picture->rows);
  sheet.canvas().draw_rgb(fitted(box, columns, rows), picture->bytes(), columns, rows);
}
/// The finding at hand, in as many lines as there is room for.
void draw_finding(const Sheet& sheet, const PixelBox& box);
/// The same text, as long as it is: "1/2 ⚠ ..."
using FindingText = FixedText<512>;
FindingText finding_text(const Sheet& sheet);
/// Large text, and below it plain text. Without room for both the first is smaller, then the second is left out.
/// @returns y below both
int draw_message(const Sheet& sheet, const PixelBox& box, std::string_view large, std::string_view plain);

using ShortText = FixedText<96>;
/// "26 h", "1 h 25 min", "13 min", "40 s"
ShortText duration(std::chrono::seconds time);
/// The table's text with its numbers.
template <class... Values>
ShortText filled_in(std::string_view pattern, Values... values) {
  ShortText text;
#pragma GCC diagnostic push
#pragma GCC diagnostic ignored "-Wformat-security"
#pragma GCC diagnostic ignored "-Wformat-nonliteral"
  text.add(pattern.data(), values...);
#pragma GCC diagnostic pop
  return text;
}

// The screens, by their file.
void draw_idle(const Sheet& sheet);
void draw_scans(const Sheet& sheet);
void draw_remove_question(const Sheet& sheet);
void draw_settings(const Sheet& sheet);
void draw_proposals(const Sheet& sheet);
void draw_preview_screen(const Sheet& sheet);
void draw_remedies(const Sheet& sheet);
void draw_contract(const Sheet& sheet);
void draw_slicing(const Sheet& sheet);
void draw_checks(const Sheet& sheet);
void draw_printing(const Sheet& sheet);
void draw_cancel_question(const Sheet& sheet);
void draw_pause(const Sheet& sheet);
void draw_raising(const Sheet& sheet);
void draw_plate(const Sheet& sheet);
void draw_interrupted(const Sheet& sheet);
void draw_fault(const Sheet& sheet);
void draw_prints(const Sheet& sheet);
void draw_light_card(const Sheet& sheet);
void draw_ending(const Sheet& sheet);

}  // namespace plumbline::firmware::inline screen
