#include "firmware/messages/printer_code.hpp"

#include <array>
#include <cmath>

namespace plumbline::firmware {
namespace {

/// By fact.
constexpr std::array<FactFormat, kAllFacts> kFormats = {{
    {"count"},
    {"of"},
    {"layer"},
    {"first_layer"},
    {"last_layer"},
    {"layers"},
    {"from_mm", 2},
    {"x_mm", 1},
    {"y_mm", 1},
    {"area_mm2", -3},
    {"volume_ml", -3},
    {"percent", -2},
    {"points"},
    {"longest_mm", -3},
    {"width_mm", 1},
    {"depth_mm", 1},
    {"height_mm", 2},
    {"lift_mm", 2},
    {"limit_mm", 2},
    {"excess_mm", 2},
    {"cell_mm", -3},
    {"pixel_mm", -3},
    {"floor", -5},
    {"turn_x_deg", -4},
    {"turn_y_deg", -4},
    {"needed_mib", 1},
    {"available_mib", 1},
    {"noise_mm", -2},
    {"most_scale", -4},
    {"most_mm", -4},
    {"off_mm", 3},
    {"cure_mm", 3},
    {"columns"},
    {"rows"},
    {"panel_columns"},
    {"panel_rows"},
    {"panel_width_mm", 2},
    {"panel_depth_mm", 2},
    {"exposure_s", -3},
    {"first_exposure_s", -3},
    {"lost_percent", -2},
    {"layer_height_mm", -3},
    {"limit_s", -3},
    {"speed_mm_min", -3},
    {"limit_mm_min", -3},
    {"needed_ml", 1},
    {"tank_ml"},
    {"lamp_c", 1},
    {"lamp_limit_c"},
    {"resin_c", 1},
    {"resin_least_c"},
    {"resin_most_c"},
    {"received_mb", 1},
    {"total_mb", 1},
    {"wait_s", 0},
    {"made_mm", 4},
    {"planned_mm", 4},
    {"step_mm", 4},
    {"fits_mm", 4},
    {"thinnest_mm", 4},
    {"thickest_mm", 4},
    {"folders"},
    {"partitions"},
    {"left_ml", 1},
    {"fill_ml", 1},
    {"board_c", 1},
    {"board_limit_c"},
    {"asked_mm", 2},
    {"delivered_mm", 2},
    {"height_over_width"},
}};
static_assert(!kFormats.back().name.empty(), "a fact has no name");

}  // namespace

const FactFormat& format_of(Fact fact) { return kFormats[static_cast<std::size_t>(fact)]; }

bool is_valid(const Told& told) {
  if (static_cast<std::size_t>(told.code) >= kAllCodes || told.count > Told::kMostFacts || told.text.back() != '\0')
    return false;
  for (std::size_t i = 0; i < told.count; ++i) {
    if (static_cast<std::size_t>(told.facts[i]) >= kAllFacts || !std::isfinite(told.values[i])) return false;
  }
  return true;
}

}  // namespace plumbline::firmware
