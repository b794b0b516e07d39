/// The screens before a print.

#include <algorithm>
#include <cmath>

#include "firmware/canvas/qr_code.hpp"
#include "firmware/messages/catalogue.hpp"
#include "firmware/screen/screen_parts.hpp"
#include "firmware/screen/setting_rows.hpp"

namespace plumbline::firmware::inline screen {
namespace {

constexpr int kRowsWithPictures = 3;  ///< fewer than without, so that the pictures are large enough
constexpr double kMegabyte = 1e6, kKilobyte = 1e3;

ShortText file_size(std::uint64_t bytes, Language language) {
  const auto size = static_cast<double>(bytes);
  ShortText text;
  if (size >= kMegabyte) {
    text.add("%s MB", decimal(size / kMegabyte, size < 10 * kMegabyte ? 1 : 0, language).c_str());
  } else if (size >= kKilobyte) {
    text.add("%.0f kB", size / kKilobyte);
  } else {
    text.add("%.0f B", size);
  }
  return text;
}

/// What is wrong with the scan at hand, or how it is printed.
void draw_hint(const Sheet& sheet, const PixelBox& box, const JobRecord& job) {
  const PrinterRecord& record = sheet.record;
  if (job.chosen && *job.chosen < record.scan_count && !record.scans[*job.chosen].problem.view().empty()) {
    const ScanRecord& scan = record.scans[*job.chosen];
    const auto told = told_words(scan.told.code, sheet.language);  // what to do has been said when it was refused
    const ToldText problem = told ? filled_in(told->sentence, scan.told, sheet.language) : ToldText();
    sheet.page.paragraph(box, told ? problem.view() : scan.problem.view(), sheet.plain(ink::kAttention, Fit::kMayCut));
    return;
  }
  if (record.has_job_file) {
    sheet.page.paragraph(box, sheet.say(Words::kJobFileAsks), sheet.plain(ink::kPale));
    return;
  }
  if (job.file_count > 1) {
    FixedText<kMostScans * 82> files;
    for (std::size_t i = 0; i < job.file_count; ++i) files.add("%s%s", i == 0 ? "" : ", ", job.files[i].c_str());
    sheet.page.paragraph(box, files.view(), sheet.plain(ink::kPale, Fit::kMayCut));
    return;
  }
  FixedText<200> text;
  const auto profile = sheet.say(Words::kProfile);
  text.add("%.*s %s", static_cast<int>(profile.size()), profile.data(), job.profile.c_str());
  const SettingRow height = setting_row(1, record, sheet.language);
  text.add(", %s", height.value.c_str());
  sheet.page.paragraph(box, text.view(), sheet.plain(ink::kPale, Fit::kMayCut));
}

ShortText resin_text(const Sheet& sheet, const MachineRecord& machine) {
  if (!machine.resin_ml()) return {};
  return filled_in(sheet.say(Words::kResinLeft), decimal(*machine.resin_ml(), 1, sheet.language).c_str());
}

/// "Lamp 31 · Resin 24 °C": of the sensors that answer.
ShortText temperatures_text(const Sheet& sheet, const MachineRecord& machine) {
  constexpr std::array kPatterns = {Words::kLampHas, Words::kResinHas, Words::kBoardHas};  // by TemperatureSite
  static_assert(kPatterns.size() == kTemperatureSiteCount);
  ShortText text;
  for (std::size_t i = 0; i < kTemperatureSiteCount; ++i) {
    const auto read = machine.latest(static_cast<TemperatureSite>(i));
    if (!read) continue;
    const auto shown =
        filled_in(sheet.say(kPatterns[i]), decimal(std::round(read->value()) + 0.0, 0, sheet.language).c_str());
    text.add("%s%s", text.view().empty() ? "" : " · ", shown.c_str());
  }
  if (!text.view().empty()) text.add(" °C");
  return text;
}

/// The address of the printer's page at the bottom, and its code at the right.
/// @returns the room that is left
PixelBox draw_address(const Sheet& sheet, const PixelBox& body) {
  std::string_view address = sheet.record.address.view();
  if (address.empty()) return body;
  PixelBox left = body;
  if (const QrCode* const code = sheet.address_code; code != nullptr) {
    const int side = code->side_in(std::min(body.height, body.width * 2 / 5));
    code->draw(sheet.canvas(), body.right() - side, body.y, side);
    if (side > 0) left = body.left_columns(body.width - side - sheet.px(8));
  }
  const Face& face = sheet.look().plain;
  constexpr std::string_view kScheme = "http://";  // browsers add it
  if (face.width(address) > left.width && address.starts_with(kScheme)) address.remove_prefix(kScheme.size());
  constexpr int kMostLines = 2;  // a machine's name can be long
  const int rows = std::min(kMostLines, Page::lines_of(address, left.width, face)) * face.line_height();
  sheet.page.paragraph(left.from_row(left.height - rows), address, sheet.plain(ink::kText, Fit::kMayCut));
  return left.top_rows(left.height - rows);
}

}  // namespace

void draw_idle(const Sheet& sheet) {
  draw_title(sheet, sheet.say(Words::kReady));
  PixelBox body = sheet.body();
  if (const MachineRecord* const machine = sheet.record.machine; machine != nullptr) {
    for (const ShortText& text : {temperatures_text(sheet, *machine), resin_text(sheet, *machine)}) {
      if (text.view().empty()) continue;
      const int rest = body.height - sheet.look().plain.line_height();
      sheet.page.line(body.from_row(rest), text.view(), sheet.plain(ink::kPale));
      body = body.top_rows(rest);
    }
  }
  body = draw_address(sheet, body);
  if (sheet.record.has_stick) {
    draw_message(sheet, body, sheet.say(Words::kStickIsIn), sheet.say(Words::kShowAgain));
  } else {
    const bool has_upload = takes(sheet.record, Command::kOffer);
    draw_message(sheet, body, sheet.say(Words::kPlugIn),
                 sheet.say(has_upload ? Words::kShowUpload : Words::kScanKinds));
  }
}

namespace {

void draw_scan_row(const Sheet& sheet, const PixelBox& room, std::size_t which) {
  const PrinterRecord& record = sheet.record;
  if (record.has_job_file) {
    sheet.page.line(room, record.job->scan.view(), sheet.plain(ink::kText, Fit::kMayCut));
    return;
  }
  const ScanRecord& scan = record.scans[which];
  const bool bad = !scan.problem.view().empty();
  FixedText<160> name;
  if (bad) name.add("⚠ ");
  if (scan.files > 1) name.add("%s: ", filled_in(sheet.say(Words::kScansAsOne), scan.files).c_str());
  name.add("%s%s", scan.name.c_str(), scan.files > 1 ? ", …" : "");
  draw_pair(sheet, room, name.view(), file_size(scan.bytes, sheet.language).view(),
            sheet.plain(bad ? ink::kAttention : ink::kText, Fit::kMayCut));
}

/// @param which  of the rows of its kind
void draw_list_row(const Sheet& sheet, const PixelBox& room, ListRow row, std::size_t which) {
  switch (row) {
    case ListRow::kScan: return draw_scan_row(sheet, room, which);
    case ListRow::kFolder: {
      const FolderRecord& folder = sheet.record.folders[which];
      FixedText<84> name;
      name.add("%s/", folder.name.c_str());
      return draw_pair(sheet, room, name.view(), filled_in(sheet.say(Words::kFolderHolds), folder.entries).view(),
                       sheet.plain(ink::kText, Fit::kMayCut));
    }
    case ListRow::kUp: sheet.page.line(room, sheet.say(Words::kFolderUp), sheet.bold()); return;
    case ListRow::kSettings: sheet.page.line(room, sheet.say(Words::kSettings), sheet.bold()); return;
    case ListRow::kRemove: sheet.page.line(room, sheet.say(Words::kDeleteScan), sheet.bold()); return;
  }
}

}  // namespace

void draw_scans(const Sheet& sheet) {
  const PrinterRecord& record = sheet.record;
  if (const auto folder = record.folder.view(); !folder.empty()) {
    draw_title(sheet, folder, ink::kBar, Fit::kMayCut);
  } else {
    draw_title(sheet, sheet.say(record.scans_uploaded ? Words::kUploadedScan : Words::kScans));
  }
  const PixelBox body = sheet.body();
  if (!record.job) {
    draw_message(sheet, body, sheet.say(Words::kPleaseWait), sheet.say(Words::kEmptyStick));
    return;
  }
  const bool pictures =
      !record.has_job_file && std::any_of(record.scans.begin(), record.scans.begin() + record.scan_count,
                                          [](const ScanRecord& scan) { return scan.picture > 0; });
  const int line = sheet.look().plain.line_height();
  ToldText left_out;
  if (!record.left_out.text.view().empty()) left_out = sheet.say(record.left_out.told, record.left_out.text.view());
  const int left_out_lines =
      left_out.view().empty() ? 0 : std::min(2, Page::lines_of(left_out.view(), body.width, sheet.look().plain));
  const int hint = (2 + left_out_lines) * line;
  const int height = pictures ? (body.height - hint) / kRowsWithPictures : row_height(sheet);
  std::size_t rows = 0;
  for (const ListRow row : kListRows) rows += rows_of(row, record);
  const std::size_t at = row_at(record, sheet.view);
  const ListPart part = shown_part(body.height - hint, height, rows, at);
  std::size_t which = 0;
  for (const ListRow row : kListRows) {
    for (std::size_t i = 0; i < rows_of(row, record); ++i, ++which) {
      if (which < part.first || which >= part.first + part.count) continue;
      const int y = body.y + static_cast<int>(which - part.first) * height;
      PixelBox room = draw_row(sheet, {body.x, y, body.width, height}, which == at);
      if (pictures && (row == ListRow::kScan || row == ListRow::kFolder || row == ListRow::kUp)) {
        const PixelBox box{room.x, room.y + sheet.px(1), height - sheet.px(2), height - sheet.px(2)};
        if (row == ListRow::kScan && record.scans[i].picture > 0 && record.scan_pictures != nullptr) {
          draw_picture(sheet, box, &(*record.scan_pictures)[i]);
        }
        room = room.from_column(height + sheet.px(4));
      }
      draw_list_row(sheet, room, row, i);
    }
  }
  const PixelBox rest = body.from_row(body.height - hint);
  if (left_out_lines > 0) {
    sheet.page.paragraph(rest.top_rows(left_out_lines * line), left_out.view(),
                         sheet.plain(ink::kAttention, Fit::kMayCut));
  }
  draw_hint(sheet, rest.from_row(left_out_lines * line), *record.job);
}

void draw_remove_question(const Sheet& sheet) {
  draw_title(sheet, sheet.say(Words::kDeleteQuestion), ink::kAttention);
  const PixelBox body = sheet.body();
  const int y = sheet.page.paragraph(body, sheet.say(Words::kAskedToDelete), sheet.bold());
  if (!sheet.record.stored) return;
  const int line = sheet.look().plain.line_height();
  sheet.page.line({body.x, y + sheet.px(6), body.width, line}, sheet.record.stored->name.view(),
                  sheet.plain(ink::kPale, Fit::kMayCut));
}

void draw_settings(const Sheet& sheet) {
  draw_title(sheet, sheet.say(Words::kSettings));
  if (!sheet.record.job) return;
  const PixelBox body = sheet.body();
  const int height = row_height(sheet);
  for (std::size_t i = 0; i < setting_rows(sheet.record); ++i) {
    const PixelBox box{body.x, body.y + static_cast<int>(i) * height, body.width, height};
    const SettingRow row = setting_row(i, sheet.record, sheet.language);
    draw_pair(sheet, draw_row(sheet, box, i == sheet.view.setting), sheet.say(row.label), row.value.view(),
              sheet.bold());
  }
}

void draw_proposals(const Sheet& sheet) {
  draw_title(sheet, sheet.say(Words::kProposals));
  const PrinterRecord& record = sheet.record;
  const Proposals& proposals = *record.proposals;
  const PixelBox body = sheet.body();
  const int legend = 2 * sheet.look().plain.line_height();
  const PixelBox upper = body.top_rows(body.height - legend);
  const int side = std::min(upper.height, body.width * 2 / 5);
  const PixelBox table = upper.left_columns(body.width - side - sheet.px(4));
  const int height = std::min(row_height(sheet), upper.height / (static_cast<int>(proposals.size()) + 1));
  constexpr int kFigures = 3;
  const int column = sheet.px(38);
  const auto write_figures = [&](const PixelBox& room, const std::array<std::string_view, kFigures>& texts,
                                 Colour ink) {
    for (int i = 0; i < kFigures; ++i) {
      const int from_right = (kFigures - i) * column;
      const PixelBox box = PixelBox{room.x + room.width - from_right, room.y, column - sheet.px(2), room.height};
      sheet.page.line(box, texts[static_cast<std::size_t>(i)], {sheet.look().plain, ink, Align::kRight, Fit::kMayCut});
    }
  };
  write_figures(table.top_rows(height).inset(sheet.px(2), 0), {"ml", "mm", "cm²"}, ink::kPale);
  const auto figure = [&](double value) { return decimal(value, value < 99.95 ? 1 : 0, sheet.language); };
  for (std::size_t i = 0; i < proposals.size(); ++i) {
    const Proposal& way = proposals[i];
    const PixelBox box{table.x, table.y + static_cast<int>(i + 1) * height, table.width, height};
    if (i == sheet.view.proposal) sheet.canvas().fill(box, ink::kChosen);
    const PixelBox room = box.inset(sheet.px(2), 0);
    const auto ml = figure(way.support_mm3 / 1000), mm = figure(way.height_mm), cm2 = figure(way.peel_mm2 / 100);
    write_figures(room, {ml.view(), mm.view(), cm2.view()}, ink::kText);
    const auto name = filled_in(sheet.say(Words::kProposal), static_cast<unsigned>(i));
    const TextStyle style = record.proposal() == i ? sheet.plain(ink::kGood) : sheet.plain();
    sheet.page.line(room.left_columns(room.width - kFigures * column),
                    i == 0 ? sheet.say(Words::kUnturned) : name.view(), style);
  }
  const PixelBox picture{body.x + body.width - side, upper.y, side, upper.height};
  const JobPictures* const pictures = record.pictures;
  const ProposalPicture* const shown = pictures != nullptr ? &pictures->proposals[sheet.view.proposal] : nullptr;
  draw_picture(sheet, picture, shown);
  sheet.page.paragraph(body.from_row(upper.height), sheet.say(Words::kProposalUnits), sheet.plain(ink::kPale));
}

void draw_preview_screen(const Sheet& sheet) {
  draw_title(sheet, sheet.say(Words::kPreview));
  const PrinterRecord& record = sheet.record;
  const Contract& sliced = *record.sliced;
  const PixelBox body = sheet.body();
  const int line = sheet.look().plain.line_height();
  int lines = 3;  // the last one for what was found
  if (record.finding_count > 0) {
    // With where it is and what to do it takes three lines, seldom four. The rest is the picture's.
    const int most = sheet.fit_of(record.findings[sheet.view.finding].told) == Fit::kMust ? 4 : 3;
    lines = 2 + std::min(most, Page::lines_of(finding_text(sheet).view(), body.width, sheet.look().plain));
  }
  const PixelBox picture = body.top_rows(body.height - lines * line - sheet.px(2));
  const JobPictures* const pictures = record.pictures;
  if (pictures != nullptr && pictures->preview.there() && pictures->issues.there()) {
    // Side by side: a picture is wider than tall, and so is what is left of the screen.
    const int half = (picture.width - sheet.px(4)) / 2;
    draw_picture(sheet, {picture.x, picture.y, half, picture.height}, &pictures->preview);
    draw_picture(sheet, {picture.x + picture.width - half, picture.y, half, picture.height}, &pictures->issues);
  } else {
    draw_picture(sheet, picture, pictures != nullptr ? &pictures->preview : nullptr);
  }
  PixelBox rest = body.from_row(body.height - lines * line);
  const auto mm = [&](double value) { return decimal(value, 1, sheet.language); };
  ShortText size;
  size.add("%s × %s × %s mm", mm(sliced.width_mm).c_str(), mm(sliced.depth_mm).c_str(), mm(sliced.height_mm).c_str());
  sheet.page.line(rest.top_rows(line), size.view(), sheet.bold());
  rest = rest.from_row(line);
  ShortText facts;
  facts.add("%s ml · %s", mm(sliced.resin_ml).c_str(), duration(sliced.time).c_str());
  const auto layers =
      filled_in(sheet.say(sliced.plan.layers == 1 ? Words::kOneLayer : Words::kLayers), sliced.plan.layers);
  draw_pair(sheet, rest.top_rows(line), facts.view(), layers.view(), sheet.plain());
  rest = rest.from_row(line);
  if (record.finding_count == 0) {
    sheet.page.line(rest.top_rows(line), sheet.say(Words::kNoFindings), sheet.plain(ink::kGood));
    return;
  }
  draw_finding(sheet, rest);
}

/// Each value with who has said it; what a person has said is green.
void draw_contract(const Sheet& sheet) {
  draw_title(sheet, sheet.say(Words::kContract));
  const Contract& contract = *sheet.record.sliced;
  const PixelBox body = sheet.body();
  const int height = row_height(sheet);
  const std::size_t first = first_contract_row(sheet.record);
  const ListPart part = shown_part(body.height, height, kContractRows - first, sheet.view.value - first);
  for (std::size_t i = 0; i < part.count; ++i) {
    const std::size_t row = first + part.first + i;
    const PixelBox box{body.x, body.y + static_cast<int>(i) * height, body.width, height};
    const PixelBox room = draw_row(sheet, box, row == sheet.view.value);
    if (row == 0) {
      sheet.page.line(room, sheet.say(Words::kSettings), sheet.bold());
      continue;
    }
    const PrintField& field = kPrintFields[row - 1];
    const ValueSource source = contract.sources[index_of(field.key)];
    const double value = value_of(contract.plan, field.key);
    int digits = 0;
    for (double scaled = value; digits < 3 && std::abs(scaled - std::round(scaled)) > 1e-6; scaled *= 10) ++digits;
    const auto said = source_words(kSourceWords[static_cast<std::size_t>(source)], sheet.language);
    ShortText shown;
    shown.add("%s%s · %.*s", decimal(value, digits, sheet.language).c_str(), field.is_whole() ? "" : field.unit,
              static_cast<int>(said.size()), said.data());
    draw_pair(sheet, room, field_words(field.name, sheet.language), shown.view(),
              sheet.plain(source == ValueSource::kPerson ? ink::kGood : ink::kText));
  }
}

void draw_slicing(const Sheet& sheet) {
  const bool proposes = sheet.record.slicing && sheet.record.slicing->proposes;
  draw_title(sheet, sheet.say(proposes ? Words::kProposing : Words::kReading));
  const PixelBox body = sheet.body();
  const int line = sheet.look().bold.line_height();
  if (sheet.record.job) {
    sheet.page.line(body.top_rows(line), sheet.record.job->scan.view(), sheet.bold(ink::kText, Fit::kMayCut));
  }
  if (!sheet.record.slicing) return;
  const SlicingRecord& slicing = *sheet.record.slicing;
  auto step = static_cast<unsigned>(slicing.stage) + 1;
  auto steps = static_cast<unsigned>(kStageCount);
  if (proposes) {
    // In this order: read, trees, normals.
    constexpr unsigned kSteps = 3;
    step = slicing.stage == Stage::kRead ? 1 : slicing.stage == Stage::kTrees ? 2 : kSteps;
    steps = kSteps;
  }
  const PixelBox rest = body.from_row(line + sheet.px(16));
  const int large = sheet.look().large.line_height();
  sheet.page.line(rest.top_rows(large), filled_in(sheet.say(Words::kStep), step, steps).view(), sheet.large());
  draw_bar(sheet, rest.from_row(large + sheet.px(6)).top_rows(sheet.px(14)), slicing.whole);
}

}  // namespace plumbline::firmware::inline screen
