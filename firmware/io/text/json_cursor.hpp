#pragma once
/// Reads JSON (RFC 8259) value by value, from a text that stays where it is. Takes nothing from the heap.

#include <cstddef>
#include <optional>
#include <span>
#include <string_view>

namespace plumbline::firmware {

/// A place in a JSON text. Each call skips white space, then either takes a whole value and moves behind it, or leaves the place as it
/// is and says that it did not.
class JsonCursor {
 public:
  explicit JsonCursor(std::string_view text) : rest_(text) {}

  /// One of { } [ ] , :
  bool take(char c);
  /// true, false or null.
  bool take_word(std::string_view word);
  /// A string, its escapes resolved.
  /// @param room  the result lies at its start
  /// @returns none: there is no string, it has a control character or a wrong escape, it is not UTF-8, or `room` is too small
  std::optional<std::string_view> take_text(std::span<char> room);
  /// A number, as it is written.
  std::optional<std::string_view> take_number();
  /// Any value, as it is written.
  /// @param levels  objects and arrays that may lie in each other
  std::optional<std::string_view> take_value(int levels);
  /// Whether only white space is left.
  bool at_end();

 private:
  void skip_space();
  bool skip_value(int levels);
  bool skip_string();

  std::string_view rest_;
};

/// A member of an object as it is written; none: it has no such member, or the text is no object.
/// @param key  without characters that JSON escapes
std::optional<std::string_view> json_member(std::string_view object, std::string_view key);

}  // namespace plumbline::firmware
