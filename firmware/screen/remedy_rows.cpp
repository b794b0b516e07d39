#include "firmware/screen/remedy_rows.hpp"

#include <algorithm>
#include <string_view>

#include "firmware/screen/screen_parts.hpp"
#include "firmware/screen/setting_rows.hpp"

namespace plumbline::firmware::inline screen {
namespace {

/// Lines that the finding has above its remedies at least.
constexpr int kFindingLines = 3;

/// The value behind a remedy's words, as people write it: "cm", "inches", "40,15 mm" in German; empty: the words say it all.
FixedText<32> remedy_value(const Remedy& remedy, Language language) {
  constexpr std::string_view kMm = "mm";
  const std::string_view key = remedy.key.view();
  std::string_view value = remedy.value.view();
  FixedText<32> text;
  if (key == "units") {
    const std::string_view unit = value == "in" ? words(Words::kInches, language) : value;
    text.add("%.*s", static_cast<int>(unit.size()), unit.data());
  } else if (value.size() > kMm.size() && value.ends_with(kMm)) {
    value.remove_suffix(kMm.size());
    for (const char letter : value) text.add("%c", letter == '.' ? decimal_point(language) : letter);
    text.add(" mm");
  }
  return text;
}

}  // namespace

FixedText<96> remedy_text(const Remedy& remedy, Language language) {
  const std::string_view said = remedy_words(remedy.key.view(), language);
  const auto value = remedy_value(remedy, language);
  FixedText<96> text;
  text.add("%.*s%s%s", static_cast<int>(said.size()), said.data(), value.view().empty() ? "" : " ", value.c_str());
  return text;
}

ClientRequest remedy_request(const Remedy& remedy) {
  ClientRequest request;
  request.command = Command::kSet;
  request.key.add("%s", remedy.key.c_str());
  request.value.add("%s", remedy.value.c_str());
  return request;
}

PixelBox remedy_row_box(const Look& look, const PixelBox& all, std::size_t rows, std::size_t row) {
  const PixelBox body = body_of(look, all);
  const auto count = static_cast<int>(rows);
  const int height = std::min(look.px(32), (body.height - kFindingLines * look.plain.line_height()) / count);
  return {body.x, body.y + body.height - (count - static_cast<int>(row)) * height, body.width, height};
}

void draw_remedies(const Sheet& sheet) {
  draw_title(sheet, sheet.say(Words::kPreview));
  const FindingRecord& finding = sheet.record.findings[sheet.view.finding];
  const PixelBox all = sheet.canvas().all(), body = sheet.body();
  const std::size_t rows = remedy_rows(sheet.record, sheet.view);
  for (std::size_t i = 0; i < rows; ++i) {
    const PixelBox room =
        draw_row(sheet, remedy_row_box(sheet.look(), all, rows, i), i == sheet.view.remedy).inset(sheet.px(4), 0);
    if (i + 1 < rows) {
      sheet.page.line(room, remedy_text(finding.remedies.list[i], sheet.language).view(), sheet.bold());
    } else {
      const bool more = sheet.view.finding + 1 < sheet.record.finding_count;
      sheet.page.line(room, sheet.say(more ? Words::kNextFinding : Words::kContract), sheet.plain());
    }
  }
  const PixelBox above = body.top_rows(remedy_row_box(sheet.look(), all, rows, 0).y - body.y);
  draw_finding(sheet, above);
}

}  // namespace plumbline::firmware::inline screen
