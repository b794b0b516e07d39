#pragma once
/// Which findings a person is told of. The others are in the manifest only: those that nobody could see on the part or do anything about.

#include <cstdint>
#include <span>

#include "slicer/checks/stack_findings.hpp"
#include "slicer/core/print_grid.hpp"
#include "slicer/supports/drawing/supports.hpp"
#include "slicer/supports/support_settings.hpp"

namespace plumbline::inline slicer {

/// The least that matters, whatever the pixels are.
struct MatteringFloors {
  /// Pieces that fall or tear off, mm3: a cube of 0.27 mm. Nobody misses it on the part, and the film bears it as it bears dust.
  static constexpr double kPiece_mm3 = 0.02;
  /// Resin traps, mm3: a ball of 0.58 mm. Light for post-curing reaches half a millimetre deep, so what is in there sets.
  static constexpr double kTrap_mm3 = 0.1;
  /// Suction cups, mm3. At 20 kPa (PeelSettings) a cup of the least height that counts, 0.5 mm, pulls with 0.02 N here: less than a tip holds.
  static constexpr double kCup_mm3 = 0.5;
  /// Hollows that drain only at the plate, mm3: a screw's hole of 5 mm, 5 mm deep. What is in a smaller one runs out when the part is taken off.
  static constexpr double kPlateTrap_mm3 = 100;
  /// Overhangs that no support reaches, mm2: what a light tip carries at most, a disc of 0.94 mm.
  static constexpr double kSag_mm2 = kLightLoad;
};

/// What plumbline itself has added to the object.
struct AddedSupports {
  bool drawn = false;
  std::uint32_t raft_layers = 0;  ///< the lowest layers, without a pixel of the object
  bool object_clear = false;      ///< the object itself keeps off the panel's edge
  std::span<const Strut> struts = {};
};

/// Sets IssueGroup::minor, and puts what matters first among what is kept. An island that no support reaches matters only if
/// a piece that matters falls or tears off: otherwise it soon grows into what is held.
/// @param grid  of the masks
void find_what_matters(StackFindings& findings, const PrintGrid& grid, const AddedSupports& added);

}  // namespace plumbline::inline slicer
