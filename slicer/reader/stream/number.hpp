#pragma once
/// Parses numbers in text, in the C locale whatever the system's locale is.

#include <cstdint>
#include <optional>
#include <string_view>

namespace plumbline::inline slicer {

/// Parses a decimal number at `first`: "1", "+2.", "-.5e-3", "1.0D+02" as Fortran writes it, also "nan", "inf", and "1.#IND" as Microsoft's library
/// writes it. Rounds to nearest; overflow gives infinity, underflow zero.
///
/// @param value  the number; unchanged if there is none
/// @returns the byte after the number, nullptr if there is no number. The caller must check that byte: "1.5x" stops at x
const char* parse_real(const char* first, const char* last, double& value);

/// The same for [first, last), a word that may have a decimal comma between digits, and no point or second comma: "-1,5e-3".
const char* parse_decimal_comma(const char* first, const char* last, double& value);

/// Parses a whole word as a count: digits only, below 2^64.
std::optional<std::uint64_t> parse_count(std::string_view word);

/// a * b; the largest value on overflow.
constexpr std::uint64_t saturating_multiply(std::uint64_t a, std::uint64_t b) {
  return a != 0 && b > UINT64_MAX / a ? UINT64_MAX : a * b;
}
/// a + b; the largest value on overflow.
constexpr std::uint64_t saturating_add(std::uint64_t a, std::uint64_t b) {
  return b > UINT64_MAX - a ? UINT64_MAX : a + b;
}

}  // namespace plumbline::inline slicer
