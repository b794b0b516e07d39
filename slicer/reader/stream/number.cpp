#include "slicer/reader/stream/number.hpp"

#include <algorithm>
#include <array>
#include <charconv>
#include <limits>

#include "slicer/reader/stream/words.hpp"

namespace plumbline::inline slicer {
namespace {

constexpr bool is_digit(char c) { return c >= '0' && c <= '9'; }
/// Fortran writes the exponent of a double with a D.
constexpr bool begins_exponent(char c) { return c == 'e' || c == 'E' || c == 'd' || c == 'D'; }

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

/// Parses the number in [first, last) with a byte of it replaced by another.
/// @returns the byte after the number, nullptr if there is none or if it is too long to be one
const char* parse_replaced(const char* first, const char* last, char found, char by, double& value) {
  std::array<char, 64> copy;
  const auto size = std::min(copy.size(), static_cast<std::size_t>(last - first));
  std::replace_copy(first, first + size, copy.begin(), found, by);
  const char* const stop = parse_real(copy.data(), copy.data() + size, value);
  return stop == nullptr || (stop == copy.end() && first + size != last) ? nullptr : first + (stop - copy.data());
}

/// Those powers of ten that are doubles.
constexpr std::array<double, 23> kPowers = {1e0,  1e1,  1e2,  1e3,  1e4,  1e5,  1e6,  1e7,  1e8,  1e9,  1e10, 1e11,
                                            1e12, 1e13, 1e14, 1e15, 1e16, 1e17, 1e18, 1e19, 1e20, 1e21, 1e22};

/// Parses what most numbers of a file are: so few digits, and so small a power of ten, that both are exact as doubles and the value is
/// rounded once (Clinger 1990). Takes a quarter of the instructions of std::from_chars.
/// @returns the byte after the number; nullptr if it is none of these, or none at all
const char* parse_short(const char* first, const char* last, double& value) {
  constexpr std::ptrdiff_t kMostPower = kPowers.size() - 1;
  constexpr std::ptrdiff_t kMostDigits = 18;  // 10^18 is below 2^63
  constexpr std::int64_t kLargest = std::int64_t{1} << 53U;
  const char* p = first;
  // Digits of a number that is too long overflow; it is left to others afterwards.
  const auto take_digits = [&p, last](std::uint64_t number) {
    const char* at = p;
    for (; at != last; ++at) {
      const unsigned digit = static_cast<unsigned char>(*at) - unsigned{'0'};
      if (digit > 9) break;
      number = number * 10 + digit;
    }
    p = at;
    return number;
  };
  const bool is_negative = p != last && *p == '-';
  if (is_negative) ++p;
  const char* begin = p;
  std::uint64_t digits = take_digits(0);
  std::ptrdiff_t count = p - begin;
  if (count == 0) return nullptr;
  std::ptrdiff_t power = 0;
  if (p != last && *p == '.') {
    begin = ++p;
    digits = take_digits(digits);
    power = begin - p;
    if (power == 0) return nullptr;
    count -= power;
  }
  const auto whole = static_cast<std::int64_t>(digits);
  if (count > kMostDigits || whole > kLargest) return nullptr;
  if (p != last && begins_exponent(*p)) {
    ++p;
    const bool is_small = p != last && *p == '-';
    if (p != last && (*p == '-' || *p == '+')) ++p;
    begin = p;
    const auto exponent = static_cast<std::ptrdiff_t>(take_digits(0));
    if (p == begin || p - begin > 3) return nullptr;
    power += is_small ? -exponent : exponent;
  }
  if (power < -kMostPower || power > kMostPower) return nullptr;
  if (p != last && *p == '#') return nullptr;
  const double size = power < 0 ? static_cast<double>(whole) / kPowers[static_cast<std::size_t>(-power)]
                                : static_cast<double>(whole) * kPowers[static_cast<std::size_t>(power)];
  value = is_negative ? -size : size;
  return p;
}

}  // namespace

const char* parse_real(const char* first, const char* last, double& value) {
  if (const char* const stop = parse_short(first, last, value)) return stop;
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
  if (stop != last && (*stop == 'd' || *stop == 'D')) return parse_replaced(first, last, *stop, 'e', value);
  value = parsed;
  return stop;
}

const char* parse_decimal_comma(const char* first, const char* last, double& value) {
  const char* const comma = std::find(first, last, ',');
  if (comma == first || comma == last || !is_digit(comma[-1]) || comma + 1 == last || !is_digit(comma[1]))
    return nullptr;
  const auto is_mark = [](char c) { return c == ',' || c == '.'; };
  if (std::find_if(first, comma, is_mark) != comma || std::find_if(comma + 1, last, is_mark) != last) return nullptr;
  return parse_replaced(first, last, ',', '.', value);
}

std::optional<std::uint64_t> parse_count(std::string_view word) {
  std::uint64_t count = 0;
  const auto [stop, error] = std::from_chars(word.data(), word.data() + word.size(), count);
  if (error != std::errc{} || stop != word.data() + word.size()) return std::nullopt;
  return count;
}

}  // namespace plumbline::inline slicer
