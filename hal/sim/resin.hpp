#pragma once
/// Resin: how deep it cures, how long it sticks.

#include <chrono>

#include "hal/clock.hpp"
#include "hal/units.hpp"

namespace plumbline {

/// A resin of the usual kind for 405 nm LCD printers; the figures are of their order, not of one product.
struct Resin {
  Dose critical = Dose(2.4);           ///< Ec: less does not gel
  double penetration_mm = 0.11;        ///< Dp: where the light has fallen to 1/e
  Distance film_stretch = 1_mm;        ///< the film follows the part that far before it comes off
  nanoseconds peel_time{200'000'000};  ///< that a small area takes to come off
  double peel_s_per_cm2 = 0.03;        ///< and what a larger one takes more

  /// Working curve: Cd = Dp ln(E / Ec), 0 where E <= Ec  (P. F. Jacobs, Rapid Prototyping & Manufacturing, 1992, ch. 4).
  /// @returns mm
  double cure_depth_mm(Dose dose) const;

  nanoseconds time_to_peel(double area_cm2) const;
};

}  // namespace plumbline
