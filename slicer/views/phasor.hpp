#pragma once
/// Points on the unit circle, bit-identical on every machine, which the sine of a C library is not.

#include <algorithm>
#include <cmath>

#include "slicer/core/numbers/lanes.hpp"

namespace plumbline {

struct Phasor {
  float re = 1, im = 0;
};

/// exp(2 pi i turns), error below 1e-6. Taylor series over an eighth of a turn on either side of each quarter.
inline Phasor phasor(float turns) {
  const float quarters = std::floor(4 * turns + 0.5F);
  const float x = (turns - 0.25F * quarters) * 6.2831853F;  // -pi/4 to pi/4
  const float x2 = x * x;
  const float s = x * (1 - x2 / 6 * (1 - x2 / 20 * (1 - x2 / 42)));
  const float c = 1 - x2 / 2 * (1 - x2 / 12 * (1 - x2 / 30 * (1 - x2 / 56)));
  switch (static_cast<int>(quarters - 4 * std::floor(quarters / 4))) {
    case 0: return {c, s};
    case 1: return {-s, c};
    case 2: return {-c, -s};
    default: return {s, -c};
  }
}

/// exp(2 pi i turns) of each lane, as phasor().
PLUMBLINE_INLINE void phasors(const Lanes& turns, Lanes& re, Lanes& im) {
  Lanes whole, quarter;
  round_lanes(whole, turns);
  const Lanes within = turns - whole;
  round_lanes(quarter, 4 * within);
  const Lanes x = (within - 0.25F * quarter) * 6.2831853F;
  const Lanes x2 = x * x;
  const Lanes s = x * (1 - x2 / 6 * (1 - x2 / 20 * (1 - x2 / 42)));
  const Lanes c = 1 - x2 / 2 * (1 - x2 / 12 * (1 - x2 / 30 * (1 - x2 / 56)));
  const IntLanes odd = (quarter == 1) | (quarter == -1);
  const IntLanes half = (quarter == 2) | (quarter == -2);
  Lanes cosine, sine;
  choose(cosine, odd, s, c);
  choose(sine, odd, c, s);
  choose(re, half | (quarter == 1), -cosine, cosine);
  choose(im, half | (quarter == -1), -sine, sine);
}

/// The angle of (re, im) in turns, -1/2 to 1/2, error below 0.001: enough to start a fit.
inline float angle_in_turns(const Phasor& p) {
  const float a = std::abs(p.re);
  const float b = std::abs(p.im);
  const float most = std::max(a, b);
  if (!(most > 0)) return 0;
  const float z = std::min(a, b) / most;
  float turns = z / (1 + 0.28086F * z * z) / 6.2831853F;
  if (b > a) turns = 0.25F - turns;
  if (p.re < 0) turns = 0.5F - turns;
  return p.im < 0 ? -turns : turns;
}

}  // namespace plumbline
