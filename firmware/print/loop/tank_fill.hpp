#pragma once
/// How much resin a print asks for. Pure functions.

#include <optional>

#include "firmware/print/status/print_observer.hpp"

namespace plumbline::firmware {

/// Resin that the plate can reach, ml; none of none. The last of a tank no longer flows under the plate.
/// @param left_ml  in the tank; none: unknown
double usable_ml(std::optional<double> left_ml, double tank_ml);

/// How far to fill the tank for a print that needs `needed_ml` from here on, ml: to a tenth above, at most a full tank.
double fill_to_ml(double needed_ml, double tank_ml);

/// Whether the tank is to be filled before a print, or before it goes on. A print that needs more than a full tank pauses anyway, so
/// a tank that is nearly full is full enough for it.
bool needs_filling(std::optional<double> left_ml, double needed_ml, double tank_ml);

/// "0.2 ml of resin are left: fill the tank to 1.0 ml, close the cover, then press start"
Spoken fill_question(std::optional<double> left_ml, double fill_ml);

}  // namespace plumbline::firmware
