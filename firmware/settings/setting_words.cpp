#include "firmware/settings/setting_words.hpp"

#include <algorithm>
#include <cstdio>
#include <numeric>

namespace plumbline {
namespace {

/// Insertions, deletions and replacements that make one word the other (Levenshtein).
std::size_t edits(std::string_view from, std::string_view to) {
  std::vector<std::size_t> row(to.size() + 1);
  std::iota(row.begin(), row.end(), std::size_t{0});
  for (std::size_t i = 0; i < from.size(); ++i) {
    std::size_t diagonal = row[0];
    row[0] = i + 1;
    for (std::size_t j = 0; j < to.size(); ++j) {
      const std::size_t above = row[j + 1];
      row[j + 1] = std::min({above + 1, row[j] + 1, diagonal + (from[i] == to[j] ? 0 : 1)});
      diagonal = above;
    }
  }
  return row.back();
}

}  // namespace

std::string printable(std::string_view text, std::size_t longest) {
  std::string shown{text};
  for (char& c : shown) {
    if (c < ' ' || c > '~') c = '?';
  }
  return shortened(shown, longest);
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
  return *std::min_element(known.begin(), known.end(),
                           [word](std::string_view a, std::string_view b) { return edits(word, a) < edits(word, b); });
}

std::optional<std::string_view> nearest_within(std::string_view word, const std::vector<std::string_view>& known) {
  if (known.empty()) return std::nullopt;
  const std::string_view near = nearest(word, known);
  if (edits(word, near) > std::max<std::size_t>(1, word.size() / 3)) return std::nullopt;
  return near;
}

std::string joined(const std::vector<std::string_view>& words) {
  std::string text;
  for (const auto word : words) text.append(text.empty() ? "" : ", ").append(word);
  return text;
}

}  // namespace plumbline
