#pragma once
/// The time of day, if this machine knows it: boards without a battery start in 1970.

#include <cstdint>
#include <ctime>
#include <optional>

#include "firmware/io/text/fixed_text.hpp"

namespace plumbline::firmware {

/// 2025-01-01T00:00:00Z: a clock that shows an earlier time was never set.
inline constexpr std::int64_t kEarliestTime = 1'735'689'600;

/// @param clock_s  s since 1970 by a clock
/// @returns the same; 0: the clock is not set
constexpr std::int64_t known_time(std::int64_t clock_s) { return clock_s >= kEarliestTime ? clock_s : 0; }

/// s since 1970 by this machine's clock; 0: it is not set.
inline std::int64_t wall_clock_s() { return known_time(std::time(nullptr)); }

/// "2026-11-25T22:10:05Z", ISO 8601 in UTC; none for 0.
inline std::optional<FixedText<64>> utc_text(std::int64_t clock_s) {
  const auto time = static_cast<std::time_t>(clock_s);
  std::tm parts{};
  if (time == 0 || ::gmtime_r(&time, &parts) == nullptr) return std::nullopt;
  FixedText<64> text;
  text.add("%04d-%02d-%02dT%02d:%02d:%02dZ", parts.tm_year + 1900, parts.tm_mon + 1, parts.tm_mday, parts.tm_hour,
           parts.tm_min, parts.tm_sec);
  return text;
}

}  // namespace plumbline::firmware
