#pragma once
/// The middle of many values, and what it tells of their deviation.

#include <algorithm>
#include <cstddef>
#include <span>

namespace plumbline {

/// Standard deviation of normally distributed values over the median of their magnitudes.
inline constexpr double kMedianToDeviation = 1.4826;

/// The middle one of `values`, the upper of two. Reorders them.
/// @param values  not empty
template <typename T>
T median(std::span<T> values) {
  const auto middle = values.begin() + static_cast<std::ptrdiff_t>(values.size() / 2);
  std::nth_element(values.begin(), middle, values.end());
  return *middle;
}

}  // namespace plumbline
