#pragma once
/// Settings of slice() and inspect().

#include <cstdint>
#include <optional>

#include "slicer/core/grey_runs.hpp"
#include "slicer/core/resin/cure_model.hpp"
#include "slicer/core/resin/peel_force.hpp"
#include "slicer/dose/adaptive_layers.hpp"
#include "slicer/orientation/clean_side.hpp"
#include "slicer/placement/base_choice.hpp"
#include "slicer/placement/floor_choice.hpp"
#include "slicer/placement/placement.hpp"
#include "slicer/reader/read_as.hpp"
#include "slicer/supports/support_settings.hpp"

namespace plumbline::inline slicer {

struct SliceSettings {
  ReadAs as = ReadAs::kAuto;
  PlacementSettings placement;
  BaseChoice base = BaseChoice::kAuto;
  FloorChoice floor;
  bool orient = false;                      ///< turn the scan the best way up; placement.rotation_degrees must be 0
  CleanSide keep_clean = CleanSide::kNone;  ///< supports' scars there cost much more when the way up is chosen
  std::optional<SupportSettings> supports;  ///< of the print, for whoever adds them, and for the choice of the way up
  bool confidence = false;                  ///< keep a map of the evidence for each part of the surface
  bool keep_all = false;                    ///< keep stray pieces and small components too
  /// mm by which every outline of a layer is moved, outwards if above 0: light cures walls a little too far out. -0.5 to 0.5
  double absolute_correction_mm = 0;
  Grey grey = Grey::kOff;     ///< of the masks; full: four rays a pixel
  CureModel cure;             ///< of the print: if it is known, add_supports() corrects the object for bleed
  AdaptiveLayers adaptive;    ///< of the print: if it is wanted, add_supports() chooses the heights of its layers
  PeelSettings peel;          ///< of the resin: for the checks of the masks only
  double overcure_mm = 0;     ///< by which a layer's light cures more than the layer: for the checks of the masks only
  std::uint32_t threads = 1;  ///< 1 to 64; the result does not depend on it
};

/// Sets the number of OpenMP threads.
/// @returns `settings` with 1 to kMaxThreads threads
SliceSettings set_threads(const SliceSettings& settings);

}  // namespace plumbline::inline slicer
