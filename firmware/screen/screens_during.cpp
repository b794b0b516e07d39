/// The screens of a print that runs or waits.

#include <algorithm>

#include "firmware/screen/screen_parts.hpp"
#include "firmware/screen/setting_rows.hpp"

namespace plumbline::firmware::inline screen {
namespace {

ShortText layer_line(const Sheet& sheet, const ProgressRecord& progress) {
  // The layer at hand: one more than those that are done.
  const std::uint32_t at = std::min(progress.layers_done + 1, progress.layers);
  return filled_in(sheet.say(Words::kLayerOf), at, progress.layers);
}

/// What the person can do about a pause.
Words pause_text(PrintState state) {
  if (state == PrintState::kPausing) return Words::kAfterLayer;
  if (state == PrintState::kCoverOpen) return Words::kCloseCover;
  if (state == PrintState::kCoolingDown) return Words::kLampCools;
  if (state == PrintState::kFeedMe) return Words::kRefill;
  return Words::kPressToGoOn;
}

Words pause_title(PrintState state) {
  if (state == PrintState::kPausing) return Words::kPausing;
  if (state == PrintState::kCoverOpen) return Words::kCoverOpen;
  if (state == PrintState::kCoolingDown) return Words::kCoolingDown;
  if (state == PrintState::kFeedMe) return Words::kResinLow;
  return Words::kPaused;
}

}  // namespace

void draw_checks(const Sheet& sheet) {
  draw_title(sheet, sheet.say(sheet.record.state == PrintState::kHoming ? Words::kHoming : Words::kChecks));
  const PixelBox body = sheet.body();
  constexpr std::size_t kRows = 6;  // in two columns
  const int height = body.height / static_cast<int>(kRows);
  for (std::size_t i = 0; i < kCheckCount; ++i) {
    const int column = i < kRows ? 0 : 1;
    const auto row = static_cast<int>(i % kRows);
    const PixelBox box{body.x + column * body.width / 2, body.y + row * height, body.width / 2, height};
    const CheckOutcome outcome = sheet.record.checks[i].outcome;
    const bool reached = outcome != CheckOutcome::kNotReached;
    const bool passed = outcome == CheckOutcome::kPassed;
    const std::string_view sign = passed ? "✓" : outcome == CheckOutcome::kFailed ? "✖" : reached ? "⚠" : "·";
    const Colour sign_ink = passed ? ink::kGood : outcome == CheckOutcome::kFailed ? ink::kFault : ink::kAttention;
    const int sign_width = sheet.px(20);
    sheet.page.line(box.left_columns(sign_width), sign, sheet.bold(reached ? sign_ink : ink::kPale));
    const auto name = static_cast<Words>(static_cast<std::size_t>(Words::kCheckMemory) + i);
    sheet.page.line(box.from_column(sign_width), sheet.say(name), sheet.plain(reached ? ink::kText : ink::kPale));
  }
}

void draw_printing(const Sheet& sheet) {
  const bool pauses = sheet.record.note == PrintNote::kPauseTaken;
  draw_title(sheet, sheet.say(pauses ? Words::kPausing : Words::kPrinting), pauses ? ink::kAttention : ink::kBar);
  if (!sheet.record.progress) return;
  const ProgressRecord& progress = *sheet.record.progress;
  const PixelBox body = sheet.body();
  const int bar = sheet.px(14);
  const double done = progress.layers > 0 ? double{1} * progress.layers_done / progress.layers : 0;
  draw_bar(sheet, body.from_row(body.height - bar), done);
  const PixelBox upper = body.top_rows(body.height - bar - sheet.px(6));

  // The mask on the left, as large as the height allows.
  const PixelBox picture = upper.left_columns(upper.width / 3);
  sheet.canvas().fill(picture, ink::kDark);
  sheet.canvas().frame(picture, sheet.px(1), ink::kTrough);
  if (sheet.record.pictures != nullptr && sheet.record.pictures->layer().there()) {
    const LayerPicture& layer = sheet.record.pictures->layer();
    const auto columns = static_cast<int>(layer.columns), rows = static_cast<int>(layer.rows);
    sheet.canvas().draw_grey(fitted(picture.inset(sheet.px(2), sheet.px(2)), columns, rows), layer.bytes(), columns,
                             rows, ink::kDark, ink::kText);
  }

  PixelBox rest = upper.from_column(picture.width + sheet.px(10));
  const auto next = [&](int height) {
    const PixelBox box = rest.top_rows(height);
    rest = rest.from_row(height);
    return box;
  };
  const int large = sheet.look().large.line_height(), line = sheet.look().plain.line_height();
  ShortText percent;
  percent.add("%u %%", static_cast<unsigned>(100 * done));
  sheet.page.line(next(large), percent.view(), sheet.large());
  sheet.page.line(next(line), filled_in(sheet.say(Words::kTimeLeft), duration(progress.left).c_str()).view(),
                  sheet.bold());
  next(sheet.px(4));
  sheet.page.line(next(line), layer_line(sheet, progress).view(), sheet.plain());
  ShortText height;
  height.add("%s mm", decimal(progress.height_mm, 2, sheet.language).c_str());
  sheet.page.line(next(line), height.view(), sheet.plain());
  if (pauses) {
    sheet.page.paragraph(rest, sheet.say(Words::kAfterLayer), sheet.plain(ink::kAttention, Fit::kMayCut));
  } else if (sheet.record.job) {
    sheet.page.line(next(line), sheet.record.job->scan.view(), sheet.plain(ink::kPale, Fit::kMayCut));
  }
}

void draw_cancel_question(const Sheet& sheet) {
  draw_title(sheet, sheet.say(Words::kCancelQuestion), ink::kAttention);
  const PixelBox body = sheet.body();
  const int y = sheet.page.paragraph(body, sheet.say(Words::kAskedToCancel), sheet.bold());
  if (!sheet.record.progress) return;
  const int line = sheet.look().plain.line_height();
  sheet.page.line({body.x, y + sheet.px(6), body.width, line}, layer_line(sheet, *sheet.record.progress).view(),
                  sheet.plain(ink::kPale));
}

void draw_pause(const Sheet& sheet) {
  draw_title(sheet, sheet.say(pause_title(sheet.record.state)), ink::kAttention);
  const PixelBox body = sheet.body();
  const int facts = sheet.look().plain.line_height();
  const PixelBox text = body.top_rows(body.height - 2 * facts);
  if (sheet.record.question.view().empty()) {
    sheet.page.paragraph(text, sheet.say(pause_text(sheet.record.state)), {sheet.look().title});
  } else {
    sheet.page.paragraph(text, sheet.say(sheet.record.question_told, sheet.record.question.view()).view(),
                         sheet.bold(ink::kText, sheet.fit_of(sheet.record.question_told)));
  }
  if (!sheet.record.progress) return;
  const PixelBox rest = body.from_row(body.height - 2 * facts);
  sheet.page.line(rest.top_rows(facts), layer_line(sheet, *sheet.record.progress).view(), sheet.plain());
  sheet.page.line(rest.from_row(facts),
                  filled_in(sheet.say(Words::kTimeLeft), duration(sheet.record.progress->left).c_str()).view(),
                  sheet.plain(ink::kPale));
}

}  // namespace plumbline::firmware::inline screen
