#pragma once

#include <charconv>
#include <cstdint>
#include <optional>
#include <string_view>

namespace plumbline {

/// The last number in a name; none: there is none, or it exceeds 64 bits.
inline std::optional<std::uint64_t> last_number(std::string_view name) {
  constexpr std::string_view kDigits = "0123456789";
  const auto last = name.find_last_of(kDigits);
  if (last == std::string_view::npos) return std::nullopt;
  const auto before = name.find_last_not_of(kDigits, last);
  const auto first = before == std::string_view::npos ? 0 : before + 1;
  std::uint64_t number = 0;
  const auto [end, error] = std::from_chars(name.data() + first, name.data() + last + 1, number);
  return error == std::errc() ? std::optional(number) : std::nullopt;
}

}  // namespace plumbline
