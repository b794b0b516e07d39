#include "slicer/core/told.hpp"

#include <cassert>
#include <cmath>
#include <limits>

#include "slicer/core/printable_text.hpp"

namespace plumbline {
namespace {

/// By ToldCode.
constexpr std::array<std::string_view, kToldCodeCount> kCodes = {
    "none",
    "island",
    "overhang",
    "free_piece",
    "tear",
    "resin_trap",
    "suction_cup",
    "touching_bound",
    "empty_layer",
    "print_height",
    "first_layer_area",
    "peel_area",
    "peel_jump",
    "units_ignored",
    "units_guessed",
    "object_small",
    "object_large",
    "object_thin",
    "points_averaged",
    "triangles_left_out",
    "faces_turned",
    "mesh_open",
    "small_holes_closed",
    "rays_crowded",
    "floor_cut",
    "pieces_left_out",
    "normals_at_random",
    "inside_out",
    "normals_flipped",
    "solids_left_out",
    "cavities_filled",
    "small_parts_stay",
    "on_its_face",
    "lies_wrong",
    "normals_estimated",
    "may_show_mark",
    "masks_late",
    "doses_off",
    "steps_lost",
    "report_full",
    "file_not_opened",
    "file_not_read",
    "format_unknown",
    "file_damaged",
    "file_cut",
    "nothing_to_print",
    "variant_unknown",
    "memory_short",
    "too_large",
    "setting_wrong",
    "no_surface",
    "too_wide",
    "too_deep",
    "too_high",
    "too_high_on_supports",
    "too_many_supports",
    "memory_needed",
    "too_small",
    "below_floor",
    "no_triangles",
    "surface_not_found",
    "mesh_changed",
    "not_points",
    "no_faces",
    "laz",
    "splats_compressed",
    "file_empty",
    "bad_sectors",
    "reading_broke",
    "archive_pixels",
    "archive_panel",
    "archive_high",
    "exposure_long",
    "light_long",
    "stage_slow",
    "last_lift_high",
    "profile_unknown",
    "stick_empty",
    "stick_two_jobs",
    "stick_other_job",
    "stick_foreign",
    "too_many_files",
    "archive_settings",
    "setting_unknown",
    "setting_value",
    "measure_part",
    "look_at_plate",
    "stick_may_go",
    "reports_on_stick",
    "reports_not_on_stick",
    "check_memory",
    "check_object",
    "check_object_hangs",
    "check_masks_clean",
    "check_masks_issues",
    "check_masks_before",
    "check_light",
    "check_lamp_dark",
    "check_lamp_lit",
    "check_panel",
    "check_panel_other",
    "check_cover_closed",
    "check_cover_open",
    "check_cover_none",
    "check_temperatures",
    "check_resin",
    "check_resin_short",
    "check_journal",
    "check_journal_none",
    "check_journal_doubt",
    "check_stage",
    "uploads_off",
    "upload_name",
    "upload_kind",
    "upload_empty",
    "upload_large",
    "upload_no_room",
    "upload_not_now",
    "upload_other",
    "upload_job_began",
    "upload_broke",
    "upload_slow",
    "upload_not_stored",
    "upload_replaced",
    "not_in_store",
    "not_removed",
    "command_not_now",
    "no_such_scan",
    "code_wrong",
    "code_old",
    "codes_too_many",
};
static_assert(!kCodes.back().empty());

/// By Fact.
constexpr std::array<FactFormat, kFactCount> kFacts = {{
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
    {"off_mm", 3},
    {"cell_mm", -3},
    {"pixel_mm", -3},
    {"cure_mm", 3},
    {"floor", -5},
    {"turn_x_deg"},
    {"turn_y_deg"},
    {"needed_mib", 1},
    {"available_mib", 1},
    {"columns"},
    {"rows"},
    {"panel_columns"},
    {"panel_rows"},
    {"panel_width_mm", 2},
    {"panel_depth_mm", 2},
    {"exposure_s", -3},
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
}};
static_assert(!kFacts.back().name.empty());

}  // namespace

Told::Told(ToldCode what, std::initializer_list<Number> numbers, std::string_view name) : code(what) {
  for (const Number& number : numbers) add(number);
  PrintableText(name, text.size() - 1).view().copy(text.data(), text.size() - 1);
}

void Told::add(const Number& number) {
  assert(count < kMostFacts);
  if (count == kMostFacts) return;
  facts[count] = number.fact;
  values[count++] = number.value;
}

double Told::of(Fact fact) const {
  for (std::size_t i = 0; i < count; ++i) {
    if (facts[i] == fact) return values[i];
  }
  return std::numeric_limits<double>::quiet_NaN();
}

bool Told::is_valid() const {
  if (static_cast<std::size_t>(code) >= kToldCodeCount || count > kMostFacts || text.back() != '\0') return false;
  for (std::size_t i = 0; i < count; ++i) {
    if (static_cast<std::size_t>(facts[i]) >= kFactCount || !std::isfinite(values[i])) return false;
  }
  return true;
}

std::string_view to_string(ToldCode code) { return kCodes[static_cast<std::size_t>(code)]; }

const FactFormat& format_of(Fact fact) { return kFacts[static_cast<std::size_t>(fact)]; }

}  // namespace plumbline
