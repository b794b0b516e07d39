#pragma once
/// The time of day, if this machine knows it: boards without a battery start in 1970.

#include <cstdint>
#include <ctime>

namespace plumbline {

/// 2025-01-01T00:00:00Z: a clock that shows an earlier time was never set.
inline constexpr std::int64_t kEarliestTime = 1'735'689'600;

/// @param clock_s  s since 1970 by a clock
/// @returns the same; 0: the clock is not set
constexpr std::int64_t known_time(std::int64_t clock_s) { return clock_s >= kEarliestTime ? clock_s : 0; }

/// s since 1970 by this machine's clock; 0: it is not set.
inline std::int64_t wall_clock_s() { return known_time(std::time(nullptr)); }

}  // namespace plumbline
