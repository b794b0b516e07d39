#include "slicer/core/resin/cure_model.hpp"

#include <algorithm>

namespace plumbline::inline slicer {

// A Taylor series of x / 1024, squared ten times.
double exponential(double x) {
  constexpr int kSquarings = 10;
  const double small = x / (1 << kSquarings);
  double sum = 1;
  for (int term = 8; term > 0; --term) sum = 1 + small / term * sum;
  for (int i = 0; i < kSquarings; ++i) sum *= sum;
  return sum;
}

namespace {

constexpr double kNothing = 1.1e-4;  ///< of a dose: it cures Dp / 10,000 deeper

/// ln y for y >= 1, by Halley's method.
double logarithm(double y) {
  constexpr double kLn2 = 0.69314718055994530942;
  double whole = 0;
  for (; y > 2; y /= 2) whole += kLn2;
  double x = y - 1;
  for (int i = 0; i < 4; ++i) {
    const double e = exponential(x);
    x += 2 * (y - e) / (y + e);
  }
  return whole + x;
}

}  // namespace

double dose_factor(double higher_mm, double penetration_mm) { return exponential(higher_mm / penetration_mm); }

CureDepths::CureDepths(const CureModel& model, double layer_height_mm, const LayerSteps& steps)
    : model_(model),
      steps_(steps),
      per_layer_(-layer_height_mm / model.penetration_mm),
      next_(part_left(1)),
      normal_(model.bottom_layers + model.faded_layers),
      ends_(part_left(kTabled) < kNothing) {
  if (!steps_.all_one()) {
    for (std::uint32_t step = 1; step <= LayerSteps::kMostStep; step += 2) {
      factor_[step] = dose_factor(layer_height_mm * step - model.layer_height_mm, model.penetration_mm);
      left_[step] = part_left(step);
    }
    return;
  }
  const auto fill = [&](std::uint32_t row, std::uint32_t first) {
    for (std::uint32_t i = 0; i < kTabled; ++i) table_[row][i] = depth_mm(first, i + 1);
    table_[row][kTabled] = depth_mm(first, kThick);
  };
  for (std::uint32_t first = 0; first < std::min(normal_, kTabledFirst); ++first) fill(first, first);
  fill(kTabledFirst, normal_);
}

double CureDepths::part_left(std::uint32_t layers) const { return exponential(std::max(-700.0, per_layer_ * layers)); }

double CureDepths::depth_mm(std::uint32_t first, std::uint32_t count) const {
  double sum = 0, largest = 0, part = 1;
  const auto add = [&](double all, double strongest) {
    sum += all;
    largest = std::max(largest, strongest);
  };
  for (; first < normal_ && count > 0; ++first, count -= count == kThick ? 0 : 1, part *= next_) {
    add(part * model_.dose_of(first), part * model_.dose_of(first));
  }
  // The others have one dose: a geometric series.
  if (count > 0) add(part * model_.dose * (1 - part_left(count)) / (1 - next_), part * model_.dose);
  return depth_of(sum, largest);
}

double CureDepths::adaptive_depth_mm(std::uint32_t first, std::uint32_t count) const {
  double sum = 0, largest = 0, part = 1;
  std::uint32_t step = steps_.of(first).step, run_end = steps_.run_end(first);
  for (std::uint32_t layer = first; count > 0 && part > kNothing; count -= count == kThick ? 0 : 1) {
    const double dose = part * factor_[step] * model_.dose_of(layer);
    sum += dose;
    largest = std::max(largest, dose);
    if (++layer >= run_end) {
      step = steps_.of(layer).step;
      run_end = steps_.run_end(layer);
    }
    part *= left_[step];
  }
  return depth_of(sum, largest);
}

double CureDepths::depth_of(double sum, double largest) const {
  const double dose = largest + (1 - model_.exchange) * (sum - largest);
  return dose > model_.critical_dose ? model_.penetration_mm * logarithm(dose / model_.critical_dose) : 0;
}

}  // namespace plumbline::inline slicer
