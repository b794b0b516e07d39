#pragma once
/// Exposures, moves and waits of a print, layer by layer, and how long they take. Pure functions.
///
/// Layer k of height h is cured with the plate's face at (k + 1) h above the film, or at h0 + k h if the first layer has a height h0
/// of its own. Then the part is lifted in two moves, slow while it peels and then fast, and comes down to the next layer in two
/// moves, fast and then slow near the film:
///
///     lift     (k + 1) h  ->  + lift_height at lift_speed  ->  + lift_height2 at lift_speed2
///     retract  (k + 2) h + retract_height2 at retract_speed  ->  (k + 2) h at retract_speed2
///
/// In an adaptive print each layer has a height of its own, and its exposure follows from that.

#include <array>
#include <chrono>
#include <cstdint>

#include "firmware/settings/board_file.hpp"
#include "firmware/settings/print_profile.hpp"
#include "hal/clock.hpp"
#include "hal/units.hpp"
#include "slicer/core/error.hpp"
#include "slicer/core/resin/cure_model.hpp"
#include "slicer/core/resin/layer_steps.hpp"

namespace plumbline::firmware {

/// A move of the Z stage.
struct StageMove {
  ZPosition target;
  Speed speed;
  bool operator==(const StageMove&) const = default;
};
using TwoStageMove = std::array<StageMove, 2>;

/// Strips of equal width along x that get exposures of their own in normal layers.
struct TestStrips {
  std::uint32_t count = 0;                                         ///< 0: none
  std::array<nanoseconds, ExposureTest::kMostStrips> exposures{};  ///< ascending
  std::uint32_t begin = 0, end = 0;                                ///< columns of the object

  /// First column of a strip. What the object does not cover belongs to the nearest strip.
  std::uint32_t column(std::uint32_t strip) const { return strip == 0 ? 0 : begin + (end - begin) * strip / count; }
};

struct PrintPlan {
  std::uint32_t layers = 0;
  LayerSteps steps;           ///< heights of an adaptive print's layers, in parts of layer_height
  Distance layer_height;      ///< of an adaptive print the least
  Distance exposed_height;    ///< of a layer that gets these exposures; differs in an adaptive print
  double penetration_mm = 0;  ///< Dp
  Distance first_layer_more;  ///< that the first layer is higher than the others; may be negative
  nanoseconds exposure{};
  nanoseconds initial_exposure{};
  TestStrips test;  ///< of which `exposure` is the longest
  std::uint32_t bottom_layers = 0;
  std::uint32_t faded_layers = 0;
  nanoseconds rest_before_exposure{};
  nanoseconds rest_after_exposure{};
  nanoseconds wait_after_lift{};
  Distance lift, lift2;
  Speed lift_speed, lift_speed2;
  Distance retract2;
  Speed retract_speed, retract_speed2;
  Distance pause_lift;
  Distance elephant_foot;  ///< width of the outline that gets no more light in bottom and faded layers than in others
  CureModel grey;          ///< known if undersides get grey pixels
  std::uint32_t grey_exposures =
      0;  ///< that a layer with grey pixels may take beyond one (GreyScale::exposures); 0 if none has any
  // Of the machine:
  ZPosition highest;  ///< that any move goes
  Speed fastest;      ///< down to the first layer, and up from the last
  Acceleration acceleration;
  nanoseconds mask_change{};     ///< from presenting a mask until it has settled, estimated
  nanoseconds least_exposure{};  ///< shorter ones are not asked of the lamp where a layer has several
};

/// @param layers  of the R-Rep or the archive, 1 to PrintGrid::kMaxLayers
/// @param layer_height_mm  of these, 0.005 to 1
/// @param steps   heights of the print's layers
/// @retval ErrorCode::kBadSetting       a speed above the Z stage's, or a slow retract longer than the lift
/// @retval ErrorCode::kExposureTooLong  an exposure above the lamp's longest, or more light in a minute than the lamp may give
/// @retval ErrorCode::kDoesNotFit       the last layer's lift ends above the Z stage's highest point: by how much
/// @retval ErrorCode::kBadSetting       an exposure test of adaptive layers, or with steps too short for the lamp
/// @retval any error of check_plan()
[[nodiscard]] Expected<PrintPlan> plan_print(const PrintProfile& profile, const MachineFile& machine,
                                             double layer_height_mm, std::uint32_t layers,
                                             const LayerSteps& steps = {});

/// Exposure time of a layer:
///
///     k < bottom                      initial
///     k = bottom + j - 1, j <= faded  initial + (normal - initial) j / (faded + 1)
///     else                            normal
///
/// times dose_factor() of its height in an adaptive print
nanoseconds exposure_of(const PrintPlan& plan, std::uint32_t layer);
/// Whether its strips get exposures of their own, of which exposure_of() is the longest.
inline bool is_tested(const PrintPlan& plan, std::uint32_t layer) {
  return plan.test.count > 0 && layer >= plan.bottom_layers + plan.faded_layers;
}
/// What a layer of its height gets above the faded ones.
nanoseconds normal_exposure_of(const PrintPlan& plan, std::uint32_t layer);

/// Height at which a layer is cured.
ZPosition height_of(const PrintPlan& plan, std::uint32_t layer);
/// Height of a layer.
Distance thickness_of(const PrintPlan& plan, std::uint32_t layer);

/// Peels the part off the film and raises it. The second move is empty if lift_height2 is 0.
TwoStageMove lift_from(const PrintPlan& plan, std::uint32_t layer);

/// Lowers the part to a layer. The second move is empty if retract_height2 is 0.
TwoStageMove retract_to(const PrintPlan& plan, std::uint32_t layer);

/// Where a pause holds the part: pause_lift above the layer, or as far as the travel goes.
StageMove pause_above(const PrintPlan& plan, std::uint32_t layer);

/// Time from the start of a layer's retract to the end of its lift.
nanoseconds layer_time(const PrintPlan& plan, std::uint32_t layer);

/// Most light in any 60 s of a print. Waits for the panel count as nothing, because they are estimates; a print that is disturbed has
/// less light.
nanoseconds most_light_in_a_minute(const PrintPlan& plan);

/// Time of the layers [first, plan.layers), without homing and the moves from and to the top.
nanoseconds remaining_time(const PrintPlan& plan, std::uint32_t first);

/// Time of a homing that begins with the plate at `from`, by the speeds of the HAL's stages (hal/z_stage.hpp).
nanoseconds homing_time(const PrintPlan& plan, ZPosition from);

/// Time from a plate at `from` to the end of the print: down, the layers [first, plan.layers), up, and the homing that ends it.
/// @param first  at most plan.layers
/// @param lit    light that the layer `first` has had
nanoseconds time_to_end(const PrintPlan& plan, ZPosition from, std::uint32_t first, nanoseconds lit = {});

/// Time of the whole print after its first homing.
nanoseconds print_time(const PrintPlan& plan);

/// Cure depth (Jacobs 1992): Dp ln(E / Ec), E = irradiance x time. Negative if the dose is too small to cure anything.
Distance cure_depth(const PrintProfile& profile, Irradiance irradiance, nanoseconds lit);

/// Resin in the masks, ml.
/// @param cured_pixels  of all layers together
double resin_ml(std::uint64_t cured_pixels, double pitch_x_mm, double pitch_y_mm, double layer_height_mm);

/// Cost in the profile's currency; 0 if the profile has no bottle volume.
double resin_cost(const PrintProfile& profile, double ml);

}  // namespace plumbline::firmware
