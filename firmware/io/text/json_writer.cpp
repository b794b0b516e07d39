#include "firmware/io/text/json_writer.hpp"

#include <cassert>
#include <charconv>
#include <cmath>

namespace plumbline::firmware {
namespace {

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

void JsonWriter::key(const PrintableText& name) {
  assert(!after_key_);
  value(name);
  put(": ");
  after_key_ = true;
}

void JsonWriter::value(const PrintableText& text) {
  begin_value();
  put('"');
  for (const char c : text.view()) {
    if (c == '"' || c == '\\') put('\\');
    put(c);
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

}  // namespace plumbline::firmware
