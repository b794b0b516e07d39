#include "hal/sim/part/deviation.hpp"

#include <algorithm>
#include <cmath>
#include <limits>
#include <numeric>

namespace plumbline::inline hal::inline sim {
namespace {

float deviation_mm(const DoseField& field, const OrientedPoint& point) {
  constexpr double kStep = 0.04, kPrecision = 1e-4;  // mm
  constexpr double kDark = -4, kNear = 1e-4;         // of the logarithm of D / Ec, which is linear in z
  constexpr float kInfinity = std::numeric_limits<float>::infinity();
  const Vec3d from = point.at.cast<double>(), normal = point.normal.cast<double>();
  const auto light = [&](double way) {
    const Vec3d p = from + way * normal;
    const double times = field.at(p[0], p[1], p[2]) / field.model().resin.critical.value();
    return times > 0 ? std::max(std::log(times), kDark) : kDark;
  };
  double here = 0, value = light(0);
  const bool cured = value >= 0;
  double next = 0, next_value = value;
  while ((next_value >= 0) == cured) {
    here = next;
    value = next_value;
    next += cured ? kStep : -kStep;
    if (std::abs(next) > kFarthestDeviation + kPrecision) return cured ? kInfinity : -kInfinity;
    next_value = light(next);
  }
  // The rule of false position; every other step halves, since the dose jumps at films.
  for (bool halve = false; std::abs(next - here) > kPrecision; halve = !halve) {
    const double share = halve ? 0.5 : std::clamp(value / (value - next_value), 0.01, 0.99);
    const double middle = here + (next - here) * share, middle_value = light(middle);
    if (std::abs(middle_value) < kNear) return static_cast<float>(middle);
    ((middle_value >= 0) == cured ? here : next) = middle;
    ((middle_value >= 0) == cured ? value : next_value) = middle_value;
  }
  return static_cast<float>((here + next) / 2);
}

}  // namespace

std::vector<float> deviations_mm(const CuredPart& part, const DoseModel& model, std::span<const OrientedPoint> truth) {
  std::vector<std::size_t> by_height(truth.size());
  std::iota(by_height.begin(), by_height.end(), 0);
  const auto height = [&](std::size_t i) { return static_cast<double>(truth[i].at[2]); };
  std::stable_sort(by_height.begin(), by_height.end(), [&](auto a, auto b) { return height(a) < height(b); });
  double reach = kFarthestDeviation;
  for (const CuredLayer& layer : part.layers())
    reach = std::max(reach, kFarthestDeviation + model.reach_mm(layer.dose));
  std::vector<float> deviations(truth.size());
  DoseField field(model);
  std::size_t next = 0;
  const auto measure_below = [&](double film_mm) {
    for (; next < by_height.size() && height(by_height[next]) + reach < film_mm; ++next) {
      deviations[by_height[next]] = deviation_mm(field, truth[by_height[next]]);
    }
    if (next < by_height.size()) field.drop_below(height(by_height[next]) - kFarthestDeviation);
  };
  part.for_each_lit_layer([&](const CuredLayer& layer, ConstBitImage mask, std::span<const GreyRun> greys) {
    measure_below(layer.z.above_film().millimetres());
    if (next < by_height.size()) field.add(layer, mask, greys);
  });
  measure_below(std::numeric_limits<double>::infinity());
  return deviations;
}

}  // namespace plumbline::inline hal::inline sim
