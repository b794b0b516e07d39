#pragma once
/// Median, and the standard deviation that follows from it.

#include <algorithm>
#include <cstddef>
#include <span>

namespace plumbline::inline slicer {

/// Standard deviation of normally distributed values, divided by the median of their magnitudes: 1 / 0.6745, the upper
/// quartile of the normal distribution.
inline constexpr double kMedianToDeviation = 1.4826;

/// The median of `values`; of an even number, the upper of the two in the middle. Reorders them.
/// @param values  not empty
template <typename T>
T median(std::span<T> values) {
  const auto middle = values.begin() + static_cast<std::ptrdiff_t>(values.size() / 2);
  std::nth_element(values.begin(), middle, values.end());
  return *middle;
}

}  // namespace plumbline::inline slicer
