#pragma once
/// Runs a plan through a model of the printer before anything moves or lights: where the stage can stand, how high each layer becomes
/// there, and how much light there is in a minute. A pure function.

#include <string_view>

#include "firmware/print/job/print_plan.hpp"

namespace plumbline::firmware {

/// How far a layer that the stage's steps make may be from the plan's, of the planned height: with constant light the dose in a
/// volume of resin is off by as much.
inline constexpr double kLayerTolerance = 0.1;

/// What the model has found. Where a height lies halfway between two steps, the worse of them counts.
struct PlanRun {
  Distance first;               ///< highest that the first layer can become
  Distance thinnest, thickest;  ///< of the layers above it; nominal if there are none
  nanoseconds most_light{};     ///< in any 60 s; waits for the panel count as nothing
};

/// A stage stands at whole steps from its end stop, nearest to where it is sent, whether a step up or down. So a layer is as high as the
/// difference of two such places. The first layer lies on the plate, whose zero is known to a step at best, so it may be off by half a step,
/// but by no more than half of its height. A plan of one layer is looked at as if it had two: its number of layers is not known yet.
/// @param name  of the profile or archive, for messages
/// @retval ErrorCode::kBadSetting       the steps make a layer higher or lower by more than kLayerTolerance: which, and what would fit
/// @retval ErrorCode::kExposureTooLong  an exposure, or the light in a minute, is more than the lamp may give
/// @retval ErrorCode::kDoesNotFit       a move ends above the stage's highest point
[[nodiscard]] Expected<PlanRun> check_plan(const PrintPlan& plan, std::string_view name, const MachineFile& machine);

}  // namespace plumbline::firmware
