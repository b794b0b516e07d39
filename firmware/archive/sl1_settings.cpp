#include "firmware/archive/sl1_settings.hpp"

#include <algorithm>
#include <iterator>
#include <utility>

#include "firmware/io/text/fixed_text.hpp"
#include "firmware/io/version.hpp"
#include "slicer/reader/stream/number.hpp"
#include "slicer/reader/stream/words.hpp"

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

std::string_view trimmed(std::string_view text) {
  const auto begin = text.find_first_not_of(" \t");
  if (begin == std::string_view::npos) return {};
  return text.substr(begin, text.find_last_not_of(" \t") + 1 - begin);
}

}  // namespace

Status read_sl1_settings(std::string_view text, Sl1Settings& settings) {
  constexpr double kMostLayers = 1e6;
  struct Rule {
    std::string_view key;
    double low, high;
    std::optional<double>* to;
  };
  std::optional<double> faded, fast, slow, mirror_x, mirror_y;
  const Rule rules[] = {
      {"layer_height", 0.005, 1, &settings.layer_height_mm},
      {"layerHeight", 0.005, 1, &settings.layer_height_mm},
      {"initial_layer_height", 0.005, 1, &settings.first_layer_height_mm},
      {"layerHeightFirst", 0.005, 1, &settings.first_layer_height_mm},
      {"exposure_time", 0.1, 1000, &settings.exposure_s},
      {"expTime", 0.1, 1000, &settings.exposure_s},
      {"initial_exposure_time", 0.1, 1000, &settings.initial_exposure_s},
      {"expTimeFirst", 0.1, 1000, &settings.initial_exposure_s},
      {"faded_layers", 0, 1000, &faded},
      {"numFade", 0, 1000, &faded},
      {"numFast", 0, kMostLayers, &fast},
      {"numSlow", 0, kMostLayers, &slow},
      {"display_width", 1, 10000, &settings.width_mm},
      {"display_height", 1, 10000, &settings.depth_mm},
      {"display_mirror_x", 0, 1, &mirror_x},
      {"display_mirror_y", 0, 1, &mirror_y},
  };
  if (text.starts_with("\xef\xbb\xbf")) text.remove_prefix(3);
  while (!text.empty()) {
    const auto line = text.substr(0, text.find_first_of("\r\n"));
    text.remove_prefix(std::min(line.size() + 1, text.size()));
    const auto equals = line.find('=');
    if (equals == std::string_view::npos) continue;
    const auto key = trimmed(line.substr(0, equals));
    const auto value = trimmed(line.substr(equals + 1));
    if (key == "display_orientation") settings.portrait = same_word(value, "portrait");
    const auto* const rule =
        std::find_if(std::begin(rules), std::end(rules), [key](const Rule& r) { return r.key == key; });
    if (rule == std::end(rules) || *rule->to) continue;
    double number = 0;
    const char* const end = parse_real(value.data(), value.data() + value.size(), number);
    if (end != value.data() + value.size() || !(number >= rule->low && number <= rule->high)) {
      return fail(ErrorCode::kMalformed, "%.*s is '%s', not a number from %g to %g.\tExport it again",
                  static_cast<int>(key.size()), key.data(), Quote(value).c_str(), rule->low, rule->high);
    }
    *rule->to = number;
  }
  if (faded && !settings.faded_layers) settings.faded_layers = static_cast<std::uint32_t>(*faded);
  if (fast && slow && !settings.layers) settings.layers = static_cast<std::uint32_t>(*fast + *slow);
  settings.mirror_x = settings.mirror_x || mirror_x.value_or(0) > 0;
  settings.mirror_y = settings.mirror_y || mirror_y.value_or(0) > 0;
  return {};
}

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
