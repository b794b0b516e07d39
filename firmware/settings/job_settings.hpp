#pragma once

#include <optional>

#include "slicer/placement/base_choice.hpp"
#include "slicer/placement/floor_choice.hpp"
#include "slicer/placement/placement.hpp"
#include "slicer/reader/read_as.hpp"

namespace plumbline {

/// How an object is printed from a stick. board/README.md has the table of the keys.
struct JobSettings {
  Units units = Units::kMillimetres;
  double scale = 1;
  bool fit = false;
  std::optional<PrintSize> size;  ///< instead of the scale
  double rotate_x_deg = 0, rotate_y_deg = 0, rotate_z_deg = 0;
  double layer_height = 0;       ///< mm; 0: the profile's
  std::optional<bool> supports;  ///< none: as the profile has it
  ReadAs as = ReadAs::kAuto;
  BaseChoice base = BaseChoice::kAuto;
  FloorChoice floor;
  bool orient = false;    ///< turn it the best way up
  bool keep_all = false;  ///< also print stray pieces
  bool operator==(const JobSettings&) const = default;
};

}  // namespace plumbline
