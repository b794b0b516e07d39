/// The screens at the end of a print, for better or worse.

#include <algorithm>
#include <cctype>

#include "firmware/io/wall_clock.hpp"
#include "firmware/messages/catalogue.hpp"
#include "firmware/print/status/fault.hpp"
#include "firmware/screen/screen_parts.hpp"
#include "firmware/screen/setting_rows.hpp"

namespace plumbline::firmware::inline screen {
namespace {

/// Of the list of prints: the rest of the screen is the picture's.
constexpr int kPrintRows = 3;

Words plate_title(const PrinterRecord& record) {
  const PrintState end = record.state == PrintState::kPlateInUse ? record.result.value_or(record.state) : record.state;
  if (end == PrintState::kFinished) return Words::kFinished;
  if (end == PrintState::kCancelled) return Words::kCancelled;
  return Words::kPlateInUse;
}

Words result_of(const KeptPrint& print) {
  switch (static_cast<PrintState>(print.result)) {
    case PrintState::kFinished: return Words::kFinished;
    case PrintState::kCancelled: return Words::kCancelled;
    case PrintState::kFault: return Words::kFault;
    default: return Words::kInterrupted;
  }
}

/// The day on which a print ended, UTC; empty: the clock was not set.
ShortText day_of(const KeptPrint& print) {
  ShortText text;
  if (const auto ended = utc_text(known_time(print.ended_at))) text.add("%.10s", ended->c_str());
  return text;
}

}  // namespace

/// The prints, and the picture and facts of the one at hand.
void draw_prints(const Sheet& sheet) {
  draw_title(sheet, sheet.say(Words::kPrints));
  const auto prints = sheet.record.prints->list();
  const PixelBox body = sheet.body();
  const int height = row_height(sheet);
  const int line = sheet.look().plain.line_height();
  const ListPart part = shown_part(kPrintRows * height, row_height(sheet), prints.size(), sheet.view.print);
  for (std::size_t i = 0; i < part.count; ++i) {
    const KeptPrint& print = prints[part.first + i];
    const PixelBox box{body.x, body.y + static_cast<int>(i) * height, body.width, height};
    const bool good = result_of(print) == Words::kFinished;
    ShortText name;
    name.add("%s%s", good ? "" : "⚠ ", PrintableText(view(print.scan), 64).c_str());
    draw_pair(sheet, draw_row(sheet, box, part.first + i == sheet.view.print), name.view(), day_of(print).view(),
              sheet.plain(good ? ink::kText : ink::kAttention, Fit::kMayCut));
  }
  const PixelBox rest = body.from_row(kPrintRows * height + sheet.px(4));
  draw_picture(sheet, rest.top_rows(rest.height - line - sheet.px(2)), sheet.kept_preview);
  const KeptPrint& print = prints[sheet.view.print];
  const Words result = result_of(print);
  const auto word = sheet.say(result);
  ShortText facts;
  facts.add("%.*s · %u/%u · %s ml", static_cast<int>(word.size()), word.data(), print.layers_done, print.layers,
            decimal(print.resin_ml, 1, sheet.language).c_str());
  const TextStyle style = sheet.plain(result == Words::kFinished ? ink::kGood : ink::kAttention);
  const PixelBox last = rest.from_row(rest.height - line);
  const PrintableText profile(view(print.profile), 32);
  // The profile's name, where there is room for it.
  const Face& face = sheet.look().plain;
  const bool both = face.width(facts.view()) + sheet.px(12) + face.width(profile.view()) <= last.width;
  if (both) return draw_pair(sheet, last, facts.view(), profile.view(), style);
  sheet.page.line(last, facts.view(), style);
}

void draw_raising(const Sheet& sheet) {
  draw_title(sheet, sheet.say(Words::kRaising));
  const bool waits = sheet.record.note == PrintNote::kCoverFirst;
  if (waits) return void(sheet.page.paragraph(sheet.body(), sheet.say(Words::kCoverFirst), {sheet.look().title}));
  draw_message(sheet, sheet.body(), sheet.say(Words::kPleaseWait), sheet.say(Words::kPartIsRaised));
}

void draw_plate(const Sheet& sheet) {
  const Words title = plate_title(sheet.record);
  draw_title(sheet, sheet.say(title), title == Words::kFinished ? ink::kGood : ink::kAttention);
  const PixelBox body = sheet.body();
  int y = draw_message(sheet, body, sheet.say(Words::kTakePartOff), {});
  y = sheet.page.paragraph(body.from_row(y - body.y), sheet.say(Words::kIsPlateEmpty), sheet.bold()) + sheet.px(6);
  const int line = sheet.look().plain.line_height();
  PixelBox rest = body.from_row(y - body.y);
  if (sheet.record.progress && rest.height >= line) {
    const ProgressRecord& progress = *sheet.record.progress;
    ShortText facts;
    facts.add("%u/%u · %s mm · %s ml", progress.layers_done, progress.layers,
              decimal(progress.height_mm, 1, sheet.language).c_str(),
              decimal(progress.resin_ml, 1, sheet.language).c_str());
    sheet.page.line(rest.top_rows(line), facts.view(), sheet.plain(ink::kPale));
    rest = rest.from_row(line);
  }
  if (sheet.record.finding_count > 0 && rest.height >= line) {
    const FindingRecord& last = sheet.record.findings[sheet.record.finding_count - 1];
    FixedText<512> finding;
    finding.add("⚠ %s", sheet.say(last.told, last.text.view()).c_str());
    const auto parts = Page::whole_parts(finding.view(), rest.width, rest.height / line, sheet.look().plain);
    sheet.page.paragraph(rest, parts, sheet.plain(ink::kAttention, Fit::kMayCut));
  }
}

void draw_interrupted(const Sheet& sheet) {
  draw_title(sheet, sheet.say(Words::kInterrupted), ink::kAttention);
  draw_message(sheet, sheet.body(), sheet.say(Words::kCanGoOn), sheet.say(Words::kGoOnOrGiveUp));
}

/// What to do comes before what happened: it is always shown in full if it is the table's.
void draw_fault(const Sheet& sheet) {
  const auto& fault = sheet.record.fault;
  if (!fault) return draw_title(sheet, sheet.say(Words::kFault), ink::kFaultBar);
  const auto word = sheet.say(Words::kFault);
  ShortText title;
  title.add("%.*s PL-%u", static_cast<int>(word.size()), word.data(), static_cast<unsigned>(fault->code));
  draw_title(sheet, title.view(), ink::kFaultBar);
  const FaultWords& known = info(fault->code, sheet.language);
  const PixelBox body = sheet.body();
  ShortText name;
  name.add("%c%.*s", std::toupper(static_cast<unsigned char>(known.title[0])), static_cast<int>(known.title.size()) - 1,
           known.title.data() + 1);
  int y = sheet.page.paragraph(body, name.view(), {sheet.look().title});
  // What is told may know a better remedy than the fault's table; the record's is English.
  const auto told = told_words(fault->told.code, sheet.language);
  const bool english = sheet.language == Language::kEnglish;
  const bool own = english ? !fault->remedy.view().empty() : told && !told->remedy.empty();
  const ToldText filled = own && !english ? filled_in(told->remedy, fault->told, sheet.language) : ToldText();
  const std::string_view remedy = !own ? known.next : english ? fault->remedy.view() : filled.view();
  const Fit fit = own && english && remedy != known.next ? Fit::kMayCut : Fit::kMust;
  y = sheet.page.paragraph(body.from_row(y - body.y + sheet.px(2)), remedy, sheet.bold(ink::kText, fit)) + sheet.px(4);
  const PixelBox rest = body.from_row(y - body.y);
  if (rest.height >= sheet.look().plain.line_height()) {
    const ToldText happened = english ? as_shown(fault->message.view())
                              : told  ? filled_in(told->sentence, fault->told, sheet.language)
                                      : ToldText();
    sheet.page.paragraph(rest, english || told ? happened.view() : known.meaning,
                         sheet.plain(ink::kPale, sheet.fit_of(fault->told)));
  }
}

void draw_ending(const Sheet& sheet) {
  draw_title(sheet, sheet.say(Words::kEnding));
  draw_message(sheet, sheet.body(), sheet.say(Words::kPleaseWait), {});
}

}  // namespace plumbline::firmware::inline screen
