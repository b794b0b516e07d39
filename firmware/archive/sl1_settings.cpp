#include "firmware/archive/sl1_settings.hpp"

#include "firmware/io/fixed_text.hpp"
#include "firmware/io/version.hpp"

namespace plumbline {
namespace {

class Lines {
 public:
  void add(const char* key, std::string_view value) {
    text_ += key;
    text_ += " = ";
    text_ += value;
    text_ += '\n';
  }
  void add(const char* key, double value) {
    FixedText<32> number;
    number.add("%.6g", value);
    add(key, number.view());
  }
  void add(const char* key, std::uint32_t value) { add(key, std::to_string(value)); }

  std::string take() { return std::move(text_); }

 private:
  std::string text_;
};

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
  lines.add("prusaSlicerVersion", std::string("plumbline ") + kVersion);
  lines.add("usedMaterial", job.resin_ml);
  return lines.take();
}

std::string sl1_prusaslicer(const Sl1Job& job) {
  const BoardFile& board = job.board;
  const PrintProfile& profile = job.profile;
  const double width = board.columns * board.pixel_pitch_x_mm;
  const double depth = board.rows * board.pixel_pitch_y_mm;
  FixedText<160> bed;
  bed.add("0x0,%.6gx0,%.6gx%.6g,0x%.6g", width, width, depth, depth);
  Lines lines;
  lines.add("bed_shape", bed.view());
  lines.add("bottle_cost", profile.bottle_cost);
  if (profile.bottle_volume > 0) lines.add("bottle_volume", profile.bottle_volume);
  lines.add("display_height", depth);
  lines.add("display_mirror_x", 0U);
  lines.add("display_mirror_y", 1U);
  lines.add("display_orientation", "landscape");
  lines.add("display_pixels_x", board.columns);
  lines.add("display_pixels_y", board.rows);
  lines.add("display_width", width);
  lines.add("exposure_time", profile.exposure_time);
  lines.add("faded_layers", profile.faded_layers);
  lines.add("initial_exposure_time", profile.initial_exposure_time);
  lines.add("initial_layer_height", double{job.grid.layer_height_mm});
  lines.add("layer_height", double{job.grid.layer_height_mm});
  lines.add("max_print_height", board.travel_mm);
  lines.add("printer_model", board.name);
  lines.add("printer_settings_id", board.name);
  lines.add("printer_technology", "SLA");
  lines.add("sla_material_settings_id", profile.name);
  lines.add("sla_print_settings_id", profile.name);
  return lines.take();
}

}  // namespace plumbline
