#pragma once
/// Resin: how deep it cures and how long it sticks to the film.

#include <chrono>

#include "hal/clock.hpp"
#include "hal/units.hpp"

namespace plumbline::inline hal::inline sim {

/// A typical resin for 405 nm LCD printers. The figures are of the usual order of magnitude, not of one product.
struct Resin {
  Dose critical = Dose(2.4);           ///< Ec: a lower dose does not gel
  double penetration_mm = 0.11;        ///< Dp: depth at which the light has fallen to 1/e
  double exchange = 0;                 ///< 0: doses of layers add up, 1: each lift brings fresh resin; see DoseField
  double blur_px = 0.5;                ///< sigma of the panel's light on the film, pixels; 0: sharp
  Distance film_stretch = 1_mm;        ///< how far the film follows the part before it comes off
  nanoseconds peel_time{200'000'000};  ///< until a small area comes off
  double peel_s_per_cm2 = 0.03;        ///< additional time for larger areas

  /// Working curve: Cd = Dp ln(E / Ec), 0 where E <= Ec  (P. F. Jacobs, Rapid Prototyping & Manufacturing, 1992, ch. 4).
  /// @returns mm
  double cure_depth_mm(Dose dose) const;

  nanoseconds time_to_peel(double area_cm2) const;
};

}  // namespace plumbline::inline hal::inline sim
