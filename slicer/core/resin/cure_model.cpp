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

CureDepths::CureDepths(const CureModel& model, double layer_height_mm)
    : model_(model), per_layer_(exponential(-std::min(700.0, layer_height_mm / model.penetration_mm))) {
  const std::uint32_t normal = model.bottom_layers + model.faded_layers;
  for (std::uint32_t first = 0; first <= kTabled; ++first) {
    if (first < kTabled && first >= normal) continue;
    for (std::uint32_t i = 0; i < kMostLayers; ++i)
      table_[first][i] = depth_mm(first < kTabled ? first : normal, i + 1);
  }
}

double CureDepths::depth_mm(std::uint32_t first, std::uint32_t count) const {
  double sum = 0, largest = 0, share = 1;
  for (std::uint32_t k = first; k < first + count; ++k, share *= per_layer_) {
    const double dose = share * model_.dose_of(k);
    sum += dose;
    largest = std::max(largest, dose);
  }
  const double dose = largest + (1 - model_.exchange) * (sum - largest);
  return dose > model_.critical_dose ? model_.penetration_mm * logarithm(dose / model_.critical_dose) : 0;
}

double CureDepths::below_film_mm(std::uint32_t first, std::uint32_t count) const {
  if (count == 0) return 0;
  count = std::min(count, kMostLayers);
  if (first >= model_.bottom_layers + model_.faded_layers) return table_[kTabled][count - 1];
  return first < kTabled ? table_[first][count - 1] : depth_mm(first, count);
}

}  // namespace plumbline::inline slicer
