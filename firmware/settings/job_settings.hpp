#pragma once

#include <optional>
#include <string_view>

#include "firmware/settings/print_fields.hpp"
#include "firmware/settings/support_choice.hpp"
#include "slicer/orientation/clean_side.hpp"
#include "slicer/placement/base_choice.hpp"
#include "slicer/placement/floor_choice.hpp"
#include "slicer/placement/placement.hpp"
#include "slicer/reader/read_as.hpp"

namespace plumbline::firmware::inline settings {

/// A layer height of a job: as the surface allows, from the profile's least to its most.
inline constexpr double kAdaptiveHeight = -1;
inline constexpr std::string_view kAdaptiveWord = "adaptive";

/// How an object is printed from a stick. board/README.md has the table of the keys.
struct JobSettings {
  Units units = Units::kMillimetres;
  double scale = 1;
  bool fit = false;
  std::optional<PrintSize> size;  ///< instead of the scale
  double rotate_x_deg = 0, rotate_y_deg = 0, rotate_z_deg = 0;
  double layer_height = 0;  ///< mm; 0: the profile's; or kAdaptiveHeight
  PrintValues values;       ///< of fields that can_be_changed(); none: as the profile or the archive has it
  SupportChoice supports;
  ReadAs as = ReadAs::kAuto;
  BaseChoice base = BaseChoice::kAuto;
  FloorChoice floor;
  bool orient = false;                      ///< turn it the best way up
  CleanSide keep_clean = CleanSide::kNone;  ///< that supports keep off, in what `orient` and proposals weigh
  bool keep_all = false;                    ///< also print stray pieces
  bool operator==(const JobSettings&) const = default;

  bool is_adaptive() const { return layer_height < 0; }
  /// All that the person has said of the print's values.
  PrintValues print_values() const {
    PrintValues all = values;
    if (layer_height > 0) all[index_of(PrintKey::kLayerHeight)] = layer_height;
    return all;
  }
};

}  // namespace plumbline::firmware::inline settings
