#pragma once

#include <charconv>
#include <optional>
#include <string_view>

namespace plumbline {

/// The decimal number that a text is; none: it is none, has something before or behind it, or does not fit into a Number.
template <class Number>
std::optional<Number> to_number(std::string_view text) {
  Number number{};
  const auto [end, problem] = std::from_chars(text.data(), text.data() + text.size(), number);
  if (problem != std::errc() || end != text.data() + text.size()) return std::nullopt;
  return number;
}

}  // namespace plumbline
