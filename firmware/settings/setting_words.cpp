#include "firmware/settings/setting_words.hpp"

#include <algorithm>
#include <cstdio>

#include "slicer/core/words/edit_distance.hpp"
#include "slicer/core/words/printable_text.hpp"

namespace plumbline::firmware::inline settings {

std::string printable(std::string_view text, std::size_t longest) {
  return std::string(PrintableText(text, longest).view());
}

std::string shortened(std::string_view text, std::size_t longest) {
  if (text.size() <= longest) return std::string{text};
  const std::size_t space = text.rfind(' ', longest);
  // A word that is longer than half of the room is cut.
  const std::size_t end = space == std::string_view::npos || space < longest / 2 ? longest : space;
  return std::string{text.substr(0, end)} + "...";
}

std::string number(double value) {
  char text[32];
  std::snprintf(text, sizeof text, "%.9g", value);
  return text;
}

std::string_view nearest(std::string_view word, const std::vector<std::string_view>& known) {
  return *std::min_element(known.begin(), known.end(), [word](std::string_view a, std::string_view b) {
    return edit_distance(word, a) < edit_distance(word, b);
  });
}

std::optional<std::string_view> nearest_within(std::string_view word, const std::vector<std::string_view>& known) {
  if (known.empty()) return std::nullopt;
  const std::string_view near = nearest(word, known);
  if (edit_distance(word, near) > std::max<std::size_t>(1, word.size() / 3)) return std::nullopt;
  return near;
}

std::string joined(const std::vector<std::string_view>& words) {
  std::string text;
  for (const auto word : words) text.append(text.empty() ? "" : ", ").append(word);
  return text;
}

}  // namespace plumbline::firmware::inline settings
