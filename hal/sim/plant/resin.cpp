#include "hal/sim/plant/resin.hpp"

#include <cmath>

namespace plumbline::inline hal::inline sim {

double Resin::cure_depth_mm(Dose dose) const {
  return dose <= critical ? 0 : penetration_mm * std::log(dose / critical);
}

nanoseconds Resin::time_to_peel(double area_cm2) const {
  const std::chrono::duration<double> more(peel_s_per_cm2 * area_cm2);
  return peel_time + std::chrono::duration_cast<nanoseconds>(more);
}

}  // namespace plumbline::inline hal::inline sim
