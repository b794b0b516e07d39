#pragma once
/// The ripple that a scanner's fringes leave in the depth of a view.

#include <array>
#include <cstdint>

#include "slicer/core/numbers/vec.hpp"
#include "slicer/views/phasor.hpp"

namespace plumbline {

/// A point at x is seen re cos a + im sin a too far along its ray, with a = 2 pi <frequency, x>.
struct Wave {
  Vec3d frequency = Vec3d::Zero();  ///< cycles per mm
  double re = 0, im = 0;            ///< mm

  /// exp(i a)
  Phasor at(const Vec3d& x) const {
    const double turns = frequency.dot(x);
    return phasor(static_cast<float>(turns - std::floor(turns)));
  }
  /// mm
  double depth(const Vec3d& x) const {
    const Phasor p = at(x);
    return re * static_cast<double>(p.re) + im * static_cast<double>(p.im);
  }
};

/// All waves of a view.
struct Ripple {
  static constexpr std::uint32_t kMaxWaves = 8;  ///< bounds the memory; a search ends when no peak stands out
  Vec3d middle =
      Vec3d::Zero();  ///< of the view, which the waves' x counts from: a step of the frequency leaves the phase there
  std::array<Wave, kMaxWaves> wave;
  std::uint32_t waves = 0;

  /// Call it after a change of the waves, before depth().
  void pack();
  /// mm
  /// @param x  where the point was seen, mm from the middle of the scan
  double depth(const Vec3d& x) const;

 private:
  static constexpr std::uint32_t kNumbers = 5;
  /// Frequencies, then amplitudes, each of all waves in a row; amplitudes of those that are none are 0.
  std::array<float, kNumbers * std::size_t{kMaxWaves}> packed_ = {};
};

}  // namespace plumbline
