#include "slicer/reader/stream/number.hpp"

#include <charconv>
#include <limits>

#include "slicer/reader/stream/words.hpp"

namespace plumbline {
namespace {

constexpr bool is_digit(char c) { return c >= '0' && c <= '9'; }

/// Whether a number that std::from_chars calls out of range is too large, not too small. Either is hundreds of powers of
/// ten away from one, so the power of its first digit tells them apart.
bool is_huge(const char* first, const char* last) {
  constexpr std::int64_t kPlenty = 1'000'000'000'000;  // far above any exponent, far below an overflow
  std::int64_t power = 0;
  bool point = false;
  bool digits = false;
  const char* p = first;
  for (; p != last && *p != 'e' && *p != 'E'; ++p) {
    if (*p == '.') {
      point = true;
    } else if (is_digit(*p)) {
      if (!digits && *p != '0') {
        digits = true;
        if (point) --power;
      } else if (digits ? !point : point) {
        power += digits ? 1 : -1;
      }
    }
  }
  if (p == last) return power > 0;
  ++p;
  const bool negative = p != last && *p == '-';
  std::int64_t exponent = 0;
  for (; p != last; ++p) {
    if (is_digit(*p) && exponent < kPlenty) exponent = exponent * 10 + (*p - '0');
  }
  return power + (negative ? -exponent : exponent) > 0;
}

/// Parses what follows "1." in "1.#INF", "-1.#IND", "1.#QNAN0". None is a usable coordinate, so all count as NaN.
/// @returns the byte after it, nullptr if it is none of them
const char* parse_microsoft_nan(const char* first, const char* last) {
  for (const std::string_view mark : {"#INF", "#IND", "#QNAN", "#SNAN"}) {
    if (static_cast<std::size_t>(last - first) < mark.size()) continue;
    if (!same_word({first, mark.size()}, mark)) continue;
    first += mark.size();
    while (first != last && is_digit(*first)) ++first;
    return first;
  }
  return nullptr;
}

}  // namespace

const char* parse_real(const char* first, const char* last, double& value) {
  if (first != last && *first == '+') {
    ++first;
    if (first != last && *first == '-') return nullptr;
  }
  double parsed = 0;
  const auto [stop, error] = std::from_chars(first, last, parsed);
  if (error == std::errc::invalid_argument) return nullptr;
  if (error == std::errc::result_out_of_range) {
    parsed = is_huge(first, stop) ? std::numeric_limits<double>::infinity() : 0.0;
  }
  if (stop != last && *stop == '#') {
    value = std::numeric_limits<double>::quiet_NaN();
    return parse_microsoft_nan(stop, last);
  }
  value = parsed;
  return stop;
}

std::optional<std::uint64_t> parse_count(std::string_view word) {
  std::uint64_t count = 0;
  const auto [stop, error] = std::from_chars(word.data(), word.data() + word.size(), count);
  if (error != std::errc{} || stop != word.data() + word.size()) return std::nullopt;
  return count;
}

}  // namespace plumbline
