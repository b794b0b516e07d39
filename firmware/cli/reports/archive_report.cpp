#include "firmware/cli/reports/archive_report.hpp"

#include <string_view>

#include "firmware/io/text/fixed_text.hpp"
#include "firmware/io/version.hpp"
#include "slicer/core/words/plural.hpp"
#include "slicer/core/words/printable_text.hpp"

namespace plumbline {

Status write_archive_report(OutputFile& out, const LayerArchive& archive, const std::string& name,
                            const JobSetup& setup, const std::string& refusal) {
  const Sl1Settings& s = archive.settings();
  FixedText<2048> text;
  text.add("print      %s: %u layer%s", PrintableText(name).c_str(), archive.layers(), plural_s(archive.layers()));
  if (s.layer_height_mm) {
    text.add(" of %.4g mm, %.2f mm high", *s.layer_height_mm, archive.layers() * *s.layer_height_mm);
  }
  text.add("\npanel      %u x %u pixels", archive.columns(), archive.rows());
  if (s.width_mm && s.depth_mm) text.add(", %.2f x %.2f mm", *s.width_mm, *s.depth_mm);
  text.add("\n");
  if (s.exposure_s) {
    text.add("exposure   %.4g s", *s.exposure_s);
    if (s.initial_exposure_s) text.add(", the first layers %.4g s", *s.initial_exposure_s);
    if (s.faded_layers) text.add(", %u layer%s in between", *s.faded_layers, plural_s(*s.faded_layers));
    text.add("\n");
  }
  if (setup.board) {
    text.add("printer    %s: %s\n", setup.printer_name.c_str(), refusal.empty() ? "has this panel" : refusal.c_str());
  }
  return out.write(text.view());
}

void write_archive_report(JsonWriter& json, const LayerArchive& archive, const std::string& name, const JobSetup& setup,
                          const std::string& refusal) {
  const Sl1Settings& s = archive.settings();
  json.begin_object();
  json.key("plumbline");
  json.begin_object(JsonWriter::Layout::kOneLine);
  json.member("version", kVersion);
  json.end_object();
  json.key("archive");
  json.begin_object();
  json.member("name", std::string_view(name));
  json.member("layers", archive.layers());
  json.member("columns", archive.columns());
  json.member("rows", archive.rows());
  if (s.layer_height_mm) json.member("layer_height_mm", *s.layer_height_mm);
  if (s.exposure_s) json.member("exposure_s", *s.exposure_s);
  if (s.initial_exposure_s) json.member("initial_exposure_s", *s.initial_exposure_s);
  if (s.faded_layers) json.member("faded_layers", *s.faded_layers);
  json.end_object();
  if (setup.board) {
    json.member("printer", std::string_view(setup.printer_name));
    json.member("fits", refusal.empty());
    if (!refusal.empty()) json.member("refusal", std::string_view(refusal));
  }
  json.end_object();
}

}  // namespace plumbline
