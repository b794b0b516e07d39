#include "firmware/io/json_writer.hpp"

#include <cassert>
#include <charconv>
#include <cmath>

namespace plumbline {
namespace {

/// Bytes of the UTF-8 sequence at the start of `text`, which is not empty; 0 if there is none.
std::size_t utf8_length(std::string_view text) {
  const auto byte = [&](std::size_t i) { return i < text.size() ? static_cast<unsigned char>(text[i]) : 0U; };
  const auto follows = [&](std::size_t i) { return (byte(i) & 0xC0U) == 0x80U; };
  const unsigned lead = byte(0);
  if (lead < 0x80) return 1;
  if (lead >= 0xC2 && lead <= 0xDF) return follows(1) ? 2 : 0;
  if (lead >= 0xE0 && lead <= 0xEF) {
    // Overlong forms, and halves of UTF-16 pairs.
    if ((lead == 0xE0 && byte(1) < 0xA0) || (lead == 0xED && byte(1) > 0x9F)) return 0;
    return follows(1) && follows(2) ? 3 : 0;
  }
  if (lead >= 0xF0 && lead <= 0xF4) {
    if ((lead == 0xF0 && byte(1) < 0x90) || (lead == 0xF4 && byte(1) > 0x8F)) return 0;
    return follows(1) && follows(2) && follows(3) ? 4 : 0;
  }
  return 0;
}

constexpr std::string_view kHexDigits = "0123456789abcdef";

}  // namespace

void JsonWriter::flush() {
  if (status_) status_ = out_.write(std::string_view(buffer_.data(), filled_));
  filled_ = 0;
}

void JsonWriter::put(char c) {
  if (filled_ == buffer_.size()) flush();
  buffer_[filled_++] = c;
}

void JsonWriter::put(std::string_view text) {
  for (const char c : text) put(c);
}

void JsonWriter::new_line() {
  put('\n');
  for (std::size_t i = 0; i < depth_; ++i) put("  ");
}

void JsonWriter::separate() {
  if (depth_ == 0) return;
  Level& level = levels_[depth_ - 1];
  if (!level.empty) put(',');
  if (level.layout == Layout::kLines) {
    new_line();
  } else if (!level.empty) {
    put(' ');
  }
  level.empty = false;
}

void JsonWriter::begin_value() {
  if (!after_key_) separate();
  after_key_ = false;
}

void JsonWriter::open(char bracket, Layout layout) {
  assert(depth_ < kMaxDepth);
  begin_value();
  put(bracket);
  levels_[depth_++] = {layout, true};
}

void JsonWriter::shut(char bracket) {
  assert(depth_ > 0 && !after_key_);
  const Level level = levels_[--depth_];
  if (!level.empty && level.layout == Layout::kLines) new_line();
  put(bracket);
}

void JsonWriter::key(std::string_view name) {
  assert(!after_key_);
  value(name);
  put(": ");
  after_key_ = true;
}

void JsonWriter::value(std::string_view text) {
  begin_value();
  put('"');
  while (!text.empty()) {
    const std::size_t length = utf8_length(text);
    const char c = text[0];
    if (length == 0) {
      put("\\ufffd");
    } else if (c == '"' || c == '\\') {
      put('\\');
      put(c);
    } else if (static_cast<unsigned char>(c) < 0x20 || c == 0x7F) {
      put("\\u00");
      put(kHexDigits[static_cast<unsigned char>(c) >> 4]);
      put(kHexDigits[static_cast<unsigned char>(c) & 15U]);
    } else {
      put(text.substr(0, length));
    }
    text.remove_prefix(length == 0 ? 1 : length);
  }
  put('"');
}

void JsonWriter::value(bool truth) {
  begin_value();
  put(truth ? std::string_view("true") : std::string_view("false"));
}

void JsonWriter::value(std::uint64_t number) {
  begin_value();
  std::array<char, 24> digits = {};
  const auto end = std::to_chars(digits.data(), digits.data() + digits.size(), number).ptr;
  put(std::string_view(digits.data(), static_cast<std::size_t>(end - digits.data())));
}

void JsonWriter::value(double number) {
  if (!std::isfinite(number)) return null();
  begin_value();
  std::array<char, 32> digits = {};
  const auto end = std::to_chars(digits.data(), digits.data() + digits.size(), number).ptr;
  put(std::string_view(digits.data(), static_cast<std::size_t>(end - digits.data())));
}

void JsonWriter::value(float number) {
  if (!std::isfinite(number)) return null();
  begin_value();
  std::array<char, 32> digits = {};
  const auto end = std::to_chars(digits.data(), digits.data() + digits.size(), number).ptr;
  put(std::string_view(digits.data(), static_cast<std::size_t>(end - digits.data())));
}

void JsonWriter::null() {
  begin_value();
  put("null");
}

void JsonWriter::hex(std::uint64_t number) {
  begin_value();
  put('"');
  for (int shift = 60; shift >= 0; shift -= 4) put(kHexDigits[(number >> shift) & 15U]);
  put('"');
}

Status JsonWriter::finish() {
  assert(depth_ == 0 && !after_key_);
  put('\n');
  flush();
  return status_;
}

}  // namespace plumbline
