#include "firmware/io/text/json_cursor.hpp"

#include <algorithm>
#include <cstdint>

namespace plumbline::firmware {
namespace {

/// Far more than any document of ours has; a bound, because each level takes some stack.
constexpr int kMostLevels = 16;

bool is_digit(char c) { return c >= '0' && c <= '9'; }

std::size_t digits_at(std::string_view text, std::size_t at) {
  std::size_t end = at;
  while (end < text.size() && is_digit(text[end])) ++end;
  return end - at;
}

/// Length of the number at the start of a text, by JSON's grammar; 0: there is none.
std::size_t number_size(std::string_view text) {
  std::size_t at = text.starts_with('-') ? 1 : 0;
  const std::size_t whole = digits_at(text, at);
  if (whole == 0 || (whole > 1 && text[at] == '0')) return 0;
  at += whole;
  if (at < text.size() && text[at] == '.') {
    const std::size_t part = digits_at(text, at + 1);
    if (part == 0) return 0;
    at += 1 + part;
  }
  if (at < text.size() && (text[at] == 'e' || text[at] == 'E')) {
    const std::size_t sign = at + 1 < text.size() && (text[at + 1] == '+' || text[at + 1] == '-') ? 1 : 0;
    const std::size_t power = digits_at(text, at + 1 + sign);
    if (power == 0) return 0;
    at += 1 + sign + power;
  }
  return at;
}

std::optional<std::uint32_t> hex4(std::string_view text) {
  if (text.size() < 4) return std::nullopt;
  std::uint32_t value = 0;
  for (const char c : text.substr(0, 4)) {
    const int digit = is_digit(c)            ? c - '0'
                      : c >= 'a' && c <= 'f' ? c - 'a' + 10
                      : c >= 'A' && c <= 'F' ? c - 'A' + 10
                                             : -1;
    if (digit < 0) return std::nullopt;
    value = 16 * value + static_cast<std::uint32_t>(digit);
  }
  return value;
}

/// Length of the UTF-8 character at the start of a text; 0: it is none.
std::size_t character_size(std::string_view text) {
  const auto byte = [text](std::size_t i) { return static_cast<unsigned char>(text[i]); };
  const unsigned char first = byte(0);
  const std::size_t size = first < 0x80   ? 1
                           : first < 0xC2 ? 0
                           : first < 0xE0 ? 2
                           : first < 0xF0 ? 3
                           : first < 0xF5 ? 4
                                          : 0;
  if (size < 2) return size;
  if (text.size() < size) return 0;
  // The second byte's range leaves out overlong forms, surrogates, and what lies beyond U+10FFFF.
  const unsigned char low = first == 0xE0 ? 0xA0 : first == 0xF0 ? 0x90 : 0x80;
  const unsigned char high = first == 0xED ? 0x9F : first == 0xF4 ? 0x8F : 0xBF;
  if (byte(1) < low || byte(1) > high) return 0;
  for (std::size_t i = 2; i < size; ++i) {
    if ((byte(i) & 0xC0U) != 0x80) return 0;
  }
  return size;
}

/// Writes a code point as UTF-8. @returns bytes written; 0: no room
std::size_t put_character(std::uint32_t code, std::span<char> room) {
  const std::size_t size = code < 0x80 ? 1 : code < 0x800 ? 2 : code < 0x10000 ? 3 : 4;
  if (room.size() < size) return 0;
  if (size == 1) {
    room[0] = static_cast<char>(code);
    return 1;
  }
  constexpr std::uint32_t kLead[] = {0, 0, 0xC0, 0xE0, 0xF0};
  for (std::size_t i = size; i-- > 1; code >>= 6U) room[i] = static_cast<char>(0x80U | (code & 0x3FU));
  room[0] = static_cast<char>(kLead[size] | code);
  return size;
}

}  // namespace

void JsonCursor::skip_space() { rest_.remove_prefix(std::min(rest_.find_first_not_of(" \t\r\n"), rest_.size())); }

bool JsonCursor::take(char c) {
  skip_space();
  if (!rest_.starts_with(c)) return false;
  rest_.remove_prefix(1);
  return true;
}

bool JsonCursor::take_word(std::string_view word) {
  skip_space();
  if (!rest_.starts_with(word)) return false;
  rest_.remove_prefix(word.size());
  return true;
}

std::optional<std::string_view> JsonCursor::take_number() {
  skip_space();
  const std::size_t size = number_size(rest_);
  if (size == 0) return std::nullopt;
  const std::string_view number = rest_.substr(0, size);
  rest_.remove_prefix(size);
  return number;
}

std::optional<std::string_view> JsonCursor::take_text(std::span<char> room) {
  skip_space();
  if (!rest_.starts_with('"')) return std::nullopt;
  std::string_view text = rest_.substr(1);
  std::size_t filled = 0;
  while (!text.empty() && text[0] != '"') {
    if (static_cast<unsigned char>(text[0]) < 0x20) return std::nullopt;
    if (text[0] != '\\') {
      const std::size_t size = character_size(text);
      if (size == 0 || room.size() - filled < size) return std::nullopt;
      text.copy(room.data() + filled, size);
      filled += size;
      text.remove_prefix(size);
      continue;
    }
    constexpr std::string_view kEscapes = "\"\\/bfnrt", kMeant = "\"\\/\b\f\n\r\t";
    if (text.size() < 2) return std::nullopt;
    std::uint32_t code = 0;
    if (const std::size_t escape = kEscapes.find(text[1]); escape != std::string_view::npos) {
      code = static_cast<unsigned char>(kMeant[escape]);
      text.remove_prefix(2);
    } else {
      const auto unit = text[1] == 'u' ? hex4(text.substr(2)) : std::nullopt;
      if (!unit) return std::nullopt;
      code = *unit;
      text.remove_prefix(6);
      if (code >= 0xDC00 && code < 0xE000) return std::nullopt;
      if (code >= 0xD800 && code < 0xDC00) {
        const auto low = text.starts_with("\\u") ? hex4(text.substr(2)) : std::nullopt;
        if (!low || *low < 0xDC00 || *low > 0xDFFF) return std::nullopt;
        code = 0x10000 + ((code - 0xD800) << 10U) + (*low - 0xDC00);
        text.remove_prefix(6);
      }
    }
    const std::size_t put = put_character(code, room.subspan(filled));
    if (put == 0) return std::nullopt;
    filled += put;
  }
  if (text.empty()) return std::nullopt;
  rest_ = text.substr(1);
  return std::string_view(room.data(), filled);
}

bool JsonCursor::skip_string() {
  if (!rest_.starts_with('"')) return false;
  for (std::size_t at = 1; at < rest_.size(); ++at) {
    if (rest_[at] == '\\') {
      ++at;
    } else if (rest_[at] == '"') {
      rest_.remove_prefix(at + 1);
      return true;
    }
  }
  return false;
}

bool JsonCursor::skip_value(int levels) {
  skip_space();
  if (skip_string() || take_number() || take_word("true") || take_word("false") || take_word("null")) return true;
  const bool object = rest_.starts_with('{');
  if ((!object && !rest_.starts_with('[')) || levels == 0) return false;
  const char end = object ? '}' : ']';
  rest_.remove_prefix(1);
  if (take(end)) return true;
  for (;;) {
    if (object) {
      skip_space();
      if (!skip_string() || !take(':')) return false;
    }
    if (!skip_value(levels - 1)) return false;
    if (take(end)) return true;
    if (!take(',')) return false;
  }
}

std::optional<std::string_view> JsonCursor::take_value(int levels) {
  skip_space();
  const std::string_view before = rest_;
  if (!skip_value(levels)) {
    rest_ = before;
    return std::nullopt;
  }
  return before.substr(0, before.size() - rest_.size());
}

bool JsonCursor::at_end() {
  skip_space();
  return rest_.empty();
}

std::optional<std::string_view> json_member(std::string_view object, std::string_view key) {
  JsonCursor cursor(object);
  if (!cursor.take('{')) return std::nullopt;
  do {
    const auto name = cursor.take_value(0);
    if (!name || !cursor.take(':')) return std::nullopt;
    const auto value = cursor.take_value(kMostLevels);
    if (!value) return std::nullopt;
    if (name->size() == key.size() + 2 && name->substr(1, key.size()) == key) return value;
  } while (cursor.take(','));
  return std::nullopt;
}

}  // namespace plumbline::firmware
