#include "firmware/cli/reports/archive_report.hpp"

#include <string_view>
#include <utility>

#include "firmware/io/text/fixed_text.hpp"
#include "firmware/io/version.hpp"
#include "slicer/core/words/plural.hpp"
#include "slicer/core/words/printable_text.hpp"

namespace plumbline::firmware {

Status write_archive_report(OutputFile& out, const LayerArchive& archive, const std::string& name,
                            const JobSetup& setup, const std::string& refusal) {
  const ArchiveSettings& s = archive.settings();
  FixedText<2048> text;
  text.add("print      %s: %u layer%s", PrintableText(name).c_str(), archive.layers(), plural_s(archive.layers()));
  if (const auto height = s.value(PrintKey::kLayerHeight)) {
    text.add(" of %.4g mm, %.2f mm high", *height, archive.layers() * *height);
  }
  text.add("\npanel      %u x %u pixels", archive.columns(), archive.rows());
  auto width = s.width_mm(), depth = s.depth_mm();
  if (archive.is_turned()) std::swap(width, depth);
  if (width && depth) text.add(", %.2f x %.2f mm", *width, *depth);
  text.add("\n");
  for (const PrintField& field : kPrintFields) {
    const auto value = s.value(field.key);
    if (value)
      text.add("%-25.*s  %.6g%s\n", static_cast<int>(field.name.size()), field.name.data(), *value, field.unit);
  }
  if (setup.board) {
    text.add("printer    %s: %s\n", setup.printer_name.c_str(),
             !refusal.empty()      ? refusal.c_str()
             : archive.is_turned() ? "has this panel; it is printed turned by 90 degrees"
                                   : "has this panel");
  }
  return out.write(text.view());
}

void write_archive_report(JsonWriter& json, const LayerArchive& archive, const std::string& name, const JobSetup& setup,
                          const std::string& refusal) {
  const ArchiveSettings& s = archive.settings();
  json.begin_object();
  json.begin_object("plumbline", kOneLine);
  json.member("version", kVersion);
  json.end_object();
  json.begin_object("archive");
  json.member("name", name);
  json.member("layers", archive.layers());
  json.member("columns", archive.columns());
  json.member("rows", archive.rows());
  for (const PrintField& field : kPrintFields) {
    if (const auto value = s.value(field.key)) json.member(field.name, *value);
  }
  json.end_object();
  if (setup.board) {
    json.member("printer", setup.printer_name);
    json.member("fits", refusal.empty());
    json.member("turned", archive.is_turned());
    if (!refusal.empty()) json.member("refusal", refusal);
  }
  json.end_object();
}

}  // namespace plumbline::firmware
