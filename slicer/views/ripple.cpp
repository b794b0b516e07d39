#include "slicer/views/ripple.hpp"

#include "slicer/core/lanes.hpp"

namespace plumbline {
namespace {

static_assert(Ripple::kMaxWaves == kLanes);

PLUMBLINE_WIDE double depth_of(const Ripple& ripple, const Vec3d& x) {
  // A lane a wave; amplitudes of those that are none are 0.
  enum { kX, kY, kZ, kRe, kIm, kNumbers };
  float number[kNumbers][kLanes];  // NOLINT(cppcoreguidelines-avoid-c-arrays)
  for (std::size_t k = 0; k < kLanes; ++k) {
    const Wave& wave = ripple.wave[k];
    number[kX][k] = static_cast<float>(wave.frequency.data()[0]);
    number[kY][k] = static_cast<float>(wave.frequency.data()[1]);
    number[kZ][k] = static_cast<float>(wave.frequency.data()[2]);
    number[kRe][k] = static_cast<float>(wave.re);
    number[kIm][k] = static_cast<float>(wave.im);
  }
  Lanes fx, fy, fz, re, im, cosine, sine;
  load(fx, number[kX]);
  load(fy, number[kY]);
  load(fz, number[kZ]);
  load(re, number[kRe]);
  load(im, number[kIm]);
  const auto px = static_cast<float>(x.data()[0]);
  const auto py = static_cast<float>(x.data()[1]);
  const auto pz = static_cast<float>(x.data()[2]);
  phasors(fx * px + fy * py + fz * pz, cosine, sine);
  return static_cast<double>(sum(re * cosine + im * sine));
}

}  // namespace

double Ripple::depth(const Vec3d& x) const { return depth_of(*this, x); }

}  // namespace plumbline
