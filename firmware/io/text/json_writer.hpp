#pragma once
/// Writes JSON as a stream.

#include <array>
#include <chrono>
#include <cmath>
#include <cstddef>
#include <cstdint>
#include <optional>
#include <string_view>
#include <type_traits>

#include "firmware/io/text/fixed_text.hpp"
#include "firmware/io/text/text_sink.hpp"
#include "slicer/core/error.hpp"
#include "slicer/core/words/printable_text.hpp"

namespace plumbline::firmware {

/// Rounds to three decimals, as the state and the reports show figures and seconds.
inline double thousandths(double value) { return std::round(value * 1000) / 1000; }
inline double thousandths(std::chrono::nanoseconds time) {
  return thousandths(std::chrono::duration<double>(time).count());
}
template <class T>
std::optional<double> thousandths(const std::optional<T>& value) {
  return value ? std::optional(thousandths(*value)) : std::nullopt;
}

/// A range that is no text: it is written as an array.
template <class Values>
concept JsonList = !std::is_convertible_v<const Values&, std::string_view> && requires(const Values& values) {
  values.begin() != values.end();
};

/// Writes one JSON value through a fixed buffer. Libraries build the document on the heap, which a job must not use.
///
/// Numbers have the fewest digits that read back as the same value, with a point in every locale; NaN and infinity become
/// null. Text is printable, so a reader may show it.
class JsonWriter {
 public:
  enum class Layout : std::uint8_t { kLines, kOneLine };
  static constexpr std::size_t kMaxDepth = 12;

  /// @param out  must outlive the writer
  explicit JsonWriter(TextSink& out) : out_(out) {}
  JsonWriter(const JsonWriter&) = delete;
  JsonWriter& operator=(const JsonWriter&) = delete;

  void begin_object(Layout layout = Layout::kLines) { open('{', layout); }
  void begin_object(std::string_view name, Layout layout = Layout::kLines) {
    key(name);
    begin_object(layout);
  }
  void end_object() { shut('}'); }
  void begin_array(Layout layout = Layout::kLines) { open('[', layout); }
  void begin_array(std::string_view name, Layout layout = Layout::kLines) {
    key(name);
    begin_array(layout);
  }
  void end_array() { shut(']'); }
  void key(const PrintableText& name);

  void value(const PrintableText& text);
  void value(const char* text) { value(PrintableText(text)); }  // else it would become a bool
  void value(bool truth);
  void value(std::uint64_t number);
  void value(std::uint32_t number) { value(std::uint64_t{number}); }
  void value(double number);
  void value(float number);
  /// In seconds.
  void value(std::chrono::nanoseconds time) { value(std::chrono::duration<double>(time).count()); }
  void value(std::chrono::seconds time) { value(static_cast<std::uint64_t>(time.count())); }
  template <std::size_t Capacity>
  void value(const FixedText<Capacity>& text) {
    value(text.view());
  }
  /// A word of an enumeration, by its to_string().
  template <class Word>
  requires std::is_enum_v<Word>
  void value(Word word) { value(to_string(word)); }
  /// Null if there is none.
  template <class T>
  void value(const std::optional<T>& v) {
    if (v) {
      value(*v);
    } else {
      null();
    }
  }
  /// An array of values on one line.
  template <JsonList Values>
  void value(const Values& values) {
    begin_array(Layout::kOneLine);
    for (const auto& v : values) value(v);
    end_array();
  }
  void null();
  /// Sixteen hexadecimal digits in quotes, since most readers can't hold 64 bits in a JSON number.
  void hex(std::uint64_t number);

  template <class T>
  void member(std::string_view name, const T& v) {
    key(name);
    value(v);
  }

  /// Must be the last call: ends the line and empties the buffer.
  /// @retval ErrorCode::kCannotWrite  the first failure of any call
  [[nodiscard]] Status finish();

 private:
  void open(char bracket, Layout layout);
  void shut(char bracket);
  void separate();  ///< comma, line and indentation, before a key or an element
  void begin_value();
  void new_line();
  void put(char c);
  void put(std::string_view text);
  void flush();

  struct Level {
    Layout layout = Layout::kLines;
    bool empty = true;
  };

  TextSink& out_;
  Status status_;
  std::array<Level, kMaxDepth> levels_ = {};
  std::size_t depth_ = 0;
  bool after_key_ = false;
  std::array<char, 4096> buffer_ = {};
  std::size_t filled_ = 0;
};

constexpr auto kOneLine = JsonWriter::Layout::kOneLine;

}  // namespace plumbline::firmware
