#pragma once
/// Lines of a text file, or of a binary file's header.

#include <cstdint>
#include <string_view>

#include "slicer/reader/stream/byte_input.hpp"

namespace plumbline::inline slicer {

struct Line {
  std::string_view text;      ///< without its end; valid until the next call of LineInput or ByteInput
  bool cut = false;           ///< longer than the window: `text` is its start, cut after a separator
  bool unterminated = false;  ///< the file ended before the line did
};

/// Lines end with LF, CR LF or CR alone. The first line end of the file decides which: after a header whose lines end
/// with CR, a first data byte of 10 is data and not part of a line end.
class LineInput {
 public:
  explicit LineInput(ByteInput& input) : input_(input) {}

  /// @returns false at the end of the file
  [[nodiscard]] Expected<bool> next(Line& line);

  /// Returns more of a line that was cut, for text in which line ends mean no more than blanks.
  /// @returns as next()
  [[nodiscard]] Expected<bool> next_part(Line& line);

  /// Consumes the rest of a line that next() cut.
  /// @returns the last byte of the line, 0 if nothing was left. A backslash there continues the line in OBJ
  [[nodiscard]] Expected<char> skip_rest();

  std::uint64_t number() const { return number_; }  ///< of the last line that next() returned, from 1
  ByteInput& input() const { return input_; }

 private:
  /// @returns the line's end in [first, last), nullptr if it is not there
  const char* find_end(const char* first, const char* last);

  ByteInput& input_;
  std::uint64_t number_ = 0;
  char terminator_ = 0;  ///< '\n', '\r', or 0 until the first line end has been seen
  bool rest_ = false;
};

}  // namespace plumbline::inline slicer
