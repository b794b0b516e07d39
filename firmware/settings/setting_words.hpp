#pragma once
/// Words of messages about settings and options.

#include <optional>
#include <string>
#include <string_view>
#include <vector>

namespace plumbline::firmware::inline settings {

/// A PrintableText of at most `longest` bytes, for messages that are put together from strings.
std::string printable(std::string_view text, std::size_t longest = 60);

/// The whole words that fit, and "..." if that is not all.
/// @param longest  characters, without the "..."
std::string shortened(std::string_view text, std::size_t longest);

/// The number with as few digits as it needs, nine at most.
std::string number(double value);

/// The known word that takes the fewest insertions, deletions and replacements to become `word` (Levenshtein).
/// @param known  not empty
std::string_view nearest(std::string_view word, const std::vector<std::string_view>& known);

/// The same, if it is near enough to be a misspelling: at most one change for every three characters, or one.
std::optional<std::string_view> nearest_within(std::string_view word, const std::vector<std::string_view>& known);

/// "columns, rows"
std::string joined(const std::vector<std::string_view>& words);

}  // namespace plumbline::firmware::inline settings
