#pragma once

#include <charconv>
#include <optional>
#include <string_view>

namespace plumbline::inline slicer {

/// Parses a whole text as a decimal number. Nothing if it is none, if anything stands before or after it, or if it doesn't fit into a Number.
template <class Number>
std::optional<Number> to_number(std::string_view text) {
  Number number{};
  const auto [end, problem] = std::from_chars(text.data(), text.data() + text.size(), number);
  if (problem != std::errc() || end != text.data() + text.size()) return std::nullopt;
  return number;
}

}  // namespace plumbline::inline slicer
