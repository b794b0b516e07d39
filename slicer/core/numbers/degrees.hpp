#pragma once
/// Sines that are bit-identical on every machine. Those of libm are not.

#include <cmath>
#include <cstdint>

namespace plumbline::inline slicer {

/// Sine and cosine of an angle in degrees, by Taylor series on [-45, 45]. The error is below 1e-16.
struct SineCosine {
  double sine, cosine;
};
inline SineCosine sine_cosine(double degrees) {
  const double turns = degrees / 90.0;
  const double quarter = std::floor(turns + 0.5);
  const double x = (turns - quarter) * 1.57079632679489661923;
  const double x2 = x * x;
  double sine = 0;
  double cosine = 0;
  for (int k = 20; k > 0; k -= 2) {  // Horner's scheme from the smallest term: x^20 / 20! is far below the last bit
    sine = (1 - sine) * x2 / (k * (k + 1));
    cosine = (1 - cosine) * x2 / (k * (k - 1));
  }
  sine = x * (1 - sine);
  cosine = 1 - cosine;
  switch ((static_cast<std::int64_t>(quarter) % 4 + 4) % 4) {
    case 1: return {cosine, -sine};
    case 2: return {-sine, -cosine};
    case 3: return {-cosine, sine};
    default: return {sine, cosine};
  }
}

}  // namespace plumbline::inline slicer
