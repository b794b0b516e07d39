#include "firmware/screen/screen_parts.hpp"

#include <algorithm>
#include <cctype>
#include <cmath>

namespace plumbline::firmware::inline screen {
namespace {

constexpr int kTitleRows = 34;
constexpr int kMargin = 8;

/// The signs on the printer's buttons.
constexpr std::array<std::string_view, kScreenButtonCount> kSigns = {"▶", "❚❚", "✖"};

/// Dark text on colours whose green is bright.
Colour text_on(Colour ground) { return green_of(ground) > 140 ? ink::kDark : ink::kText; }

}  // namespace

PixelBox body_of(const Look& look, const PixelBox& all) {
  const int top = look.px(kTitleRows + 6), bottom = look.px(kButtonRows + 4);
  return PixelBox{0, top, all.width, all.height - top - bottom}.inset(look.px(kMargin), 0);
}

PixelBox Sheet::body() const { return body_of(page.look(), page.canvas().all()); }

int row_height(const Sheet& sheet) { return sheet.px(22); }

PixelBox draw_row(const Sheet& sheet, const PixelBox& box, bool chosen) {
  if (chosen) sheet.canvas().fill(box, ink::kChosen);
  return box.inset(sheet.px(4), 0);
}

void draw_pair(const Sheet& sheet, const PixelBox& room, std::string_view left, std::string_view right,
               const TextStyle& style) {
  const int width = sheet.look().plain.width(right);
  sheet.page.line(room.left_columns(room.width - width - sheet.px(8)), left, style);
  sheet.page.line(room.from_column(room.width - width), right, {sheet.look().plain, style.ink, Align::kRight});
}

ListPart shown_part(int height, int row, std::size_t rows, std::size_t at) {
  const auto count = std::min(rows, static_cast<std::size_t>(height / row));
  return {std::min(at > count / 2 ? at - count / 2 : 0, rows - count), count};
}

void draw_title(const Sheet& sheet, std::string_view title, Colour bar, Fit fit) {
  Canvas& canvas = sheet.canvas();
  canvas.fill(canvas.all(), ink::kGround);
  ShortText code;
  if (!sheet.record.code.view().empty()) {
    code = filled_in(sheet.say(Words::kPageCode), sheet.record.code.c_str());
    title = code.view();
    bar = ink::kAttention;
  }
  const PixelBox box = canvas.all().top_rows(sheet.px(kTitleRows));
  canvas.fill(box, bar);
  const PixelBox room = box.inset(sheet.px(kMargin), 0);
  const int end = sheet.page.line(room, title, {sheet.look().title, text_on(bar), Align::kLeft, fit});
  const PixelBox rest = room.from_column(end - room.x + sheet.px(12));
  // The printer's name, where there is room for it.
  if (rest.width >= sheet.look().plain.width(sheet.record.printer.view())) {
    sheet.page.line(rest, sheet.record.printer.view(), {sheet.look().plain, text_on(bar), Align::kRight, Fit::kMayCut});
  }
}

void draw_buttons(const Sheet& sheet) {
  Canvas& canvas = sheet.canvas();
  const PixelBox bar = canvas.all().from_row(canvas.rows() - sheet.px(kButtonRows));
  const auto uses = buttons_of(sheet.record, sheet.view);
  const int gap = sheet.px(2);
  for (std::size_t i = 0; i < kScreenButtonCount; ++i) {
    const int left = bar.width * static_cast<int>(i) / 3, right = bar.width * static_cast<int>(i + 1) / 3;
    const PixelBox button = PixelBox{left, bar.y, right - left, bar.height}.inset(gap / 2, 0);
    canvas.fill(button, ink::kBar);
    if (!uses[i]) continue;
    const PixelBox room = button.inset(sheet.px(3), sheet.px(3));
    sheet.page.line(room.top_rows(room.height / 2), kSigns[i], {sheet.look().bold, ink::kAttention, Align::kCentre});
    sheet.page.line(room.from_row(room.height / 2), sheet.say(uses[i]->label),
                    {sheet.look().bold, ink::kText, Align::kCentre});
  }
}

void draw_bar(const Sheet& sheet, const PixelBox& box, double fraction) {
  sheet.canvas().fill(box, ink::kTrough);
  const double clamped = std::clamp(fraction, 0.0, 1.0);
  sheet.canvas().fill(box.left_columns(static_cast<int>(std::lround(clamped * box.width))), ink::kGood);
}

FindingText finding_text(const Sheet& sheet) {
  const PrinterRecord& record = sheet.record;
  const FindingRecord& shown = record.findings[sheet.view.finding];
  FindingText text;
  if (record.finding_count > 1) text.add("%zu/%zu ", sheet.view.finding + 1, record.finding_count);
  text.add("⚠ %s", sheet.say(shown.told, shown.text.view()).c_str());
  return text;
}

void draw_finding(const Sheet& sheet, const PixelBox& box) {
  const FindingText text = finding_text(sheet);
  const Face& face = sheet.look().plain;
  const auto parts = Page::whole_parts(text.view(), box.width, box.height / face.line_height(), face);
  const Fit fit = sheet.fit_of(sheet.record.findings[sheet.view.finding].told);
  sheet.page.paragraph(box, parts, sheet.plain(ink::kAttention, fit));
}

int draw_message(const Sheet& sheet, const PixelBox& box, std::string_view large, std::string_view plain) {
  const Look& look = sheet.look();
  const auto rows = [&](std::string_view text, const Face& face) {
    return Page::lines_of(text, box.width, face) * face.line_height();
  };
  const int rows_below = plain.empty() ? 0 : sheet.px(4) + rows(plain, look.plain);
  const Face& face = rows(large, look.large) + rows_below <= box.height ? look.large : look.bold;
  int y = sheet.page.paragraph(box, large, {face}) + sheet.px(4);
  const bool fits = rows(large, face) + rows_below <= box.height;
  if (rows_below > 0 && fits) y = sheet.page.paragraph(box.from_row(y - box.y), plain, sheet.plain(ink::kPale));
  return y;
}

ToldText as_shown(std::string_view english) {
  struct Rewriting {
    std::string_view from, to;
  };
  constexpr std::array<Rewriting, 4> kButtons{
      {{"press start", "press ▶"}, {"Press start", "Press ▶"}, {"cancel if ", "✖ if "}, {"or cancel", "or ✖"}}};
  ToldText text;
  for (const std::string_view article : {"the ", "a ", "an ", "no "}) {
    if (!english.starts_with(article)) continue;
    text.add("%c", std::toupper(static_cast<unsigned char>(english[0])));
    english.remove_prefix(1);
    break;
  }
  while (!english.empty()) {
    const auto* const button = std::find_if(kButtons.begin(), kButtons.end(),
                                            [english](const Rewriting& one) { return english.starts_with(one.from); });
    const bool is_button = button != kButtons.end();
    const std::string_view next = is_button ? button->to : english.substr(0, 1);
    text.add("%.*s", static_cast<int>(next.size()), next.data());
    english.remove_prefix(is_button ? button->from.size() : 1);
  }
  return text;
}

ShortText duration(std::chrono::seconds time) {
  const auto seconds = static_cast<long long>(time.count());
  ShortText text;
  if (seconds < 60) {
    text.add("%lld s", seconds);
  } else if (seconds < 3600) {
    text.add("%lld min", (seconds + 30) / 60);
  } else if (seconds < 36000) {
    const long long minutes = (seconds + 30) / 60;
    text.add("%lld h %lld min", minutes / 60, minutes % 60);
  } else {
    text.add("%lld h", (seconds + 1800) / 3600);
  }
  return text;
}

}  // namespace plumbline::firmware::inline screen
