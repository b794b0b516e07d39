#pragma once
/// Numbers in text, in the C locale whatever the system's is.

#include <cstdint>
#include <optional>
#include <string_view>

namespace plumbline {

/// Reads a decimal number at `first`: "1", "+2.", "-.5e-3", also "nan", "inf", and "1.#IND" as Microsoft's library
/// writes them. Rounded to nearest; what is too large becomes infinite, what is too small zero.
///
/// @param value  the number; untouched where there is none
/// @returns the byte behind the number, nullptr where none stands. The caller looks at what follows: "1.5x" is no
/// number.
const char* parse_real(const char* first, const char* last, double& value);

/// A whole word as a count: digits only, below 2^64.
std::optional<std::uint64_t> parse_count(std::string_view word);

/// a * b, or the largest value where that is more.
constexpr std::uint64_t saturating_multiply(std::uint64_t a, std::uint64_t b) {
  return a != 0 && b > UINT64_MAX / a ? UINT64_MAX : a * b;
}
/// a + b, or the largest value where that is more.
constexpr std::uint64_t saturating_add(std::uint64_t a, std::uint64_t b) {
  return b > UINT64_MAX - a ? UINT64_MAX : a + b;
}

}  // namespace plumbline
