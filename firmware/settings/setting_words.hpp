#pragma once
/// Words of the messages about settings files.

#include <optional>
#include <string>
#include <string_view>
#include <vector>

namespace plumbline {

/// A file may hold what a terminal would obey, and more of it than fits a message: neither is left.
std::string printable(std::string_view text);

/// Nine digits, and no more than are needed.
std::string number(double value);

/// @param known  not empty
/// @returns that which takes the fewest insertions, deletions and replacements to become `word` (Levenshtein)
std::string_view nearest(std::string_view word, const std::vector<std::string_view>& known);

/// The same, if it is near enough to be what was meant: at most one change for every three characters, or one.
std::optional<std::string_view> nearest_within(std::string_view word, const std::vector<std::string_view>& known);

/// "columns, rows"
std::string joined(const std::vector<std::string_view>& words);

}  // namespace plumbline
