#include "slicer/views/ripple.hpp"

#include "slicer/core/numbers/lanes.hpp"

namespace plumbline {
namespace {

static_assert(Ripple::kMaxWaves == kLanes);

PLUMBLINE_WIDE double depth_of(const float* numbers, const Vec3d& x) {
  Lanes fx, fy, fz, re, im, cosine, sine;  // a lane a wave
  load(fx, numbers);
  load(fy, numbers + kLanes);
  load(fz, numbers + 2 * kLanes);
  load(re, numbers + 3 * kLanes);
  load(im, numbers + 4 * kLanes);
  const auto px = static_cast<float>(x.data()[0]);
  const auto py = static_cast<float>(x.data()[1]);
  const auto pz = static_cast<float>(x.data()[2]);
  phasors(fx * px + fy * py + fz * pz, cosine, sine);
  return static_cast<double>(sum(re * cosine + im * sine));
}

}  // namespace

void Ripple::pack() {
  for (std::size_t k = 0; k < waves; ++k) {
    const Wave& w = wave[k];
    std::size_t at = k;
    for (const double number : {w.frequency[0], w.frequency[1], w.frequency[2], w.re, w.im}) {
      packed_[at] = static_cast<float>(number);
      at += kMaxWaves;
    }
  }
}

double Ripple::depth(const Vec3d& x) const { return depth_of(packed_.data(), x - middle); }

}  // namespace plumbline
