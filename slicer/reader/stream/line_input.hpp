#pragma once
/// Lines of a text, or of a binary file's head.

#include <cstdint>
#include <string_view>

#include "slicer/reader/stream/byte_input.hpp"

namespace plumbline {

struct Line {
  std::string_view text;      ///< without its end; valid until the next call of LineInput or ByteInput
  bool cut = false;           ///< longer than the window: `text` is its start, up to the end of a word
  bool unterminated = false;  ///< the file ended before the line did
};

/// Lines end with LF, with CR LF or with CR alone. Which, the first line end of the file decides once for all:
/// behind a head that ends its lines with CR, a first data byte of 10 is data.
class LineInput {
 public:
  explicit LineInput(ByteInput& input) : input_(input) {}

  /// @returns false at the end of the file
  [[nodiscard]] Expected<bool> next(Line& line);

  /// Uses up what next() left of a line that was cut, in pieces.
  /// @returns the last byte of the line, 0 where nothing was left: a backslash there continues the line
  [[nodiscard]] Expected<char> skip_rest();

  std::uint64_t number() const { return number_; }  ///< of the line that next() gave last, from 1
  ByteInput& input() const { return input_; }

 private:
  /// @returns the line's end in [first, last), nullptr where it is not in sight
  const char* find_end(const char* first, const char* last);

  ByteInput& input_;
  std::uint64_t number_ = 0;
  char terminator_ = 0;  ///< '\n', '\r', or 0 until the first line end has been seen
  bool rest_ = false;
};

}  // namespace plumbline
