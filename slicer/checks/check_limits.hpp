#pragma once
/// What the checks let pass.

#include <cstdint>

#include "slicer/core/regions/island_share.hpp"
#include "slicer/core/resin/peel_force.hpp"
#include "slicer/placement/placement.hpp"

namespace plumbline::inline slicer {

/// Which new pixels are overhangs.
enum class OverhangRule : std::uint8_t {
  kEroded,       ///< UVtools': those that remain when they are eroded
  kNeedSupport,  ///< the support finder's: those that would get a tip below an overhang, with its default settings
  kNone,  ///< none: the masks have the finder's tips, and places that no support reaches are findings of their own
};

/// Defaults are UVtools' as far as it has the check. They are pixels where UVtools counts pixels, whatever the pitch. UVtools has
/// two sets of them: those of its library and command line (IslandDetectionConfiguration and its like), and those of its window
/// (UserSettings). Where these differ, the more useful one is here, and the other one is named.
struct CheckLimits {
  IslandShare island;
  std::uint32_t overhang_reach = 40;  ///< pixels: ErodeIterations; 49 in the window
  OverhangRule overhangs = OverhangRule::kEroded;
  std::uint32_t drain_pixels = 10;  ///< RequiredBlackPixelsToDrain: a smaller opening between layers drains nothing
  /// Of the largest region of a resin trap: RequiredAreaToProcessCheck of the window. The library's is 4, but traps that small are
  /// those of one layer between the grey edges of supports.
  std::uint32_t trap_pixels = 17;
  /// A hollow that is no higher is none: the light of the layer that closes it cures the resin in it. 0: all are traps, as in UVtools.
  double cured_gap_mm = 0;
  std::uint32_t suction_pixels = 100;        ///< RequiredAreaToConsiderSuctionCup; 10000 in the window
  double suction_height_mm = 0.5;            ///< RequiredHeightToConsiderSuctionCup
  std::uint32_t bound_margin = kEdgeMargin;  ///< pixels: MarginLeft and its like
  bool has_panel = false;                    ///< the grid is a panel, so its edge is one
  double travel_mm = 0;                      ///< of the Z stage; 0: unknown

  // UVtools calls a region an island if less than a sixteenth of it is held. Tips of 0.4 mm, 3 to 4 mm apart, hold a hundredth to a
  // fiftieth of a flat underside, and that is enough. So a region is no island if it rests on two tips or more and all of it is near them.
  /// Least share of the region that they touch, as its inverse: of green_strength_mpa (5 MPa) 55 kPa, three times what FEP of 0.1 mm
  /// peels with (AmeraLabs: 12 to 18 kPa).
  std::uint32_t island_tips_divisor = 90;
  double island_tips_mm2 = 0.05;  ///< that they touch at least: a light tip has 0.07
  /// Farthest place from what they touch: the radius of support_area_per_tip, and the tenths by which held area lags behind.
  static constexpr double kIslandTipsReach_mm = 2.6;

  // UVtools has no such limits.
  /// Of the largest region of a hollow that the plate closes, such as a hole of a raft. The low pressure in it pulls at the plate, not
  /// at the part, so only a large one matters: at 20 kPa this is 0.5 N, what 1 mm2 of first layer holds (PeelSettings). It is what
  /// the window's 10000 pixels are with pixels of 0.05 mm. UVtools has suction_pixels there, too, if air reaches the hollow from above
  /// in the end, and finds nothing if it stays closed, as in a bowl on its rim.
  double plate_suction_mm2 = 25;
  double first_layer_mm2 = 10;  ///< three tips of supports hold as much
  /// A third of a 6 inch panel of 68 x 120 mm. Release films let go of full plates, too, but the lift has to be slow.
  double peel_mm2 = 2700;
  /// A tenth of that panel: a lift that suits the layers below may be too fast for the next one.
  double peel_jump_mm2 = 800;
  PeelSettings peel;  ///< what tears: see there
  /// Height of a needle over its width: a column of 0.5 mm that is 40 mm high.
  static constexpr double kNeedleRatio = 80;
  /// A thin wall is that long and high at least, mm.
  static constexpr double kThinWall_mm = 2;
};

}  // namespace plumbline::inline slicer
