#include "firmware/archive/sl1_config.hpp"

#include <algorithm>
#include <array>
#include <iterator>
#include <numeric>
#include <string>
#include <string_view>
#include <vector>

#include "firmware/archive/archive_settings.hpp"
#include "firmware/io/text/fixed_text.hpp"
#include "firmware/io/version.hpp"

namespace plumbline::firmware::inline archive {
namespace {

class Lines {
 public:
  void add(std::string_view key, std::string_view value) {
    lines_.emplace_back(key).append(" = ").append(value).append("\n");
  }
  void add(std::string_view key, const char* value) { add(key, std::string_view(value)); }
  void add(std::string_view key, double value) {
    FixedText<32> number;
    number.add("%.6g", value);
    add(key, number.view());
  }
  void add(std::string_view key, std::uint32_t value) { add(key, std::string_view(std::to_string(value))); }

  /// In the order of their keys.
  std::string take() {
    std::sort(lines_.begin(), lines_.end());
    return std::accumulate(lines_.begin(), lines_.end(), std::string());
  }

 private:
  std::vector<std::string> lines_;
};

/// The profile's settings that .sl1 archives have no key for, as UVtools writes and reads them.
std::string notes_of(const PrintProfile& profile) {
  std::string notes = "START_CUSTOM_VALUES\\n";
  for (const NoteKey& note : kNoteKeys) {
    FixedText<80> text;
    text.add("%s_%.6g\\n", note.name, value_of(profile, kPrintFields[index_of(note.key)]));
    notes += text.view();
  }
  return notes + "END_CUSTOM_VALUES";
}

/// Adds the keys that describe the printer. PrusaSlicer's first row has the largest y and ours the smallest, hence display_mirror_y.
void add_printer(const BoardFile& board, const PrintProfile& profile, Lines& lines) {
  const double width = board.columns * board.pixel_pitch_x_mm;
  const double depth = board.rows * board.pixel_pitch_y_mm;
  FixedText<160> bed;
  bed.add("0x0,%.6gx0,%.6gx%.6g,0x%.6g", width, width, depth, depth);
  lines.add("bed_shape", bed.view());
  lines.add("display_height", depth);
  lines.add("display_mirror_x", 0U);
  lines.add("display_mirror_y", 1U);
  lines.add("display_orientation", "landscape");
  lines.add("display_pixels_x", board.columns);
  lines.add("display_pixels_y", board.rows);
  lines.add("display_width", width);
  lines.add("max_print_height", board.travel_mm);
  lines.add("printer_model", board.name);
  lines.add("printer_notes", notes_of(profile));
  lines.add("printer_settings_id", board.name);
  lines.add("printer_technology", "SLA");
}

void add_print(const PrintProfile& profile, double layer_height_mm, Lines& lines) {
  lines.add("bottle_cost", profile.bottle_cost);
  if (profile.bottle_volume > 0) lines.add("bottle_volume", profile.bottle_volume);
  lines.add("exposure_time", profile.exposure_time);
  lines.add("faded_layers", profile.faded_layers);
  lines.add("initial_exposure_time", profile.initial_exposure_time);
  lines.add("initial_layer_height", layer_height_mm);
  lines.add("layer_height", layer_height_mm);
  lines.add("sla_material_settings_id", profile.name);
  lines.add("sla_print_settings_id", profile.name);
}

void add_corrections(std::string_view key, const std::array<double, 3>& by, Lines& lines) {
  for (std::size_t i = 0; i < 3; ++i) lines.add(std::string(key) + "xyz"[i], by[i]);
}

}  // namespace

std::string sl1_config(const Sl1Job& job) {
  const PrintProfile& profile = job.profile;
  Lines lines;
  lines.add("action", "print");
  lines.add("expTime", profile.exposure_time);
  lines.add("expTimeFirst", profile.initial_exposure_time);
  lines.add("expUserProfile", 0U);
  lines.add("hollow", 0U);
  lines.add("jobDir", kSl1Layer);
  lines.add("layerHeight", double{job.grid.layer_height_mm});
  lines.add("materialName", profile.name);
  lines.add("numFade", profile.faded_layers);
  lines.add("numFast", job.grid.layers);
  lines.add("numSlow", 0U);
  lines.add("printProfile", profile.name);
  lines.add("printTime", job.seconds);
  lines.add("printerModel", job.board.name);
  lines.add("printerProfile", job.board.name);
  lines.add("printerVariant", "default");
  lines.add("prusaSlicerVersion", std::string_view(std::string("plumbline ") + kVersion));
  lines.add("usedMaterial", job.resin_ml);
  return lines.take();
}

std::string sl1_prusaslicer(const Sl1Job& job) {
  Lines lines;
  add_printer(job.board, job.profile, lines);
  add_print(job.profile, double{job.grid.layer_height_mm}, lines);
  return lines.take();
}

std::string slicer_printer(const BoardFile& board, const MachineFile& machine, const PrintProfile& profile) {
  Lines lines;
  add_printer(board, profile, lines);
  lines.add("elefant_foot_compensation", profile.elefant_foot_compensation);
  lines.add("gamma_correction", machine.panel.grey.has_grey() ? 1U : 0U);  // 0: black and white
  lines.add("absolute_correction", profile.absolute_correction);
  add_corrections("relative_correction_", board.relative_correction, lines);
  const auto limits = [&](const char* shortest, const char* longest, PrintKey key) {
    const PrintField& field = kPrintFields[index_of(key)];
    lines.add(shortest, field.low);
    lines.add(longest, std::min(field.high, machine.max_exposure_s));
  };
  limits("min_exposure_time", "max_exposure_time", PrintKey::kExposureTime);
  limits("min_initial_exposure_time", "max_initial_exposure_time", PrintKey::kInitialExposureTime);
  lines.add("sla_archive_format", "SL1");
  lines.add("thumbnails", "400x400");
  return lines.take();
}

std::string slicer_print(const PrintProfile& profile) {
  Lines lines;
  add_print(profile, profile.layer_height, lines);
  add_corrections("material_correction_", profile.material_correction, lines);
  lines.add("supports_enable", profile.supports_enable ? 1U : 0U);
  lines.add("support_buildplate_only", profile.supports.buildplate_only ? 1U : 0U);
  // PrusaSlicer wants a pad's brim to reach beyond its slope, which ours need not, and has no keys for how supports are found.
  constexpr std::string_view kOurs[] = {"support_overhang_angle", "support_overhang_span", "support_area_per_tip"};
  for (const SupportField& field : kSupportFields) {
    const std::string_view key = field.key;
    const bool ours = std::find(std::begin(kOurs), std::end(kOurs), key) != std::end(kOurs);
    if (!ours && !key.starts_with("pad_")) lines.add(key, profile.supports.*field.member);
  }
  return lines.take();
}

}  // namespace plumbline::firmware::inline archive
