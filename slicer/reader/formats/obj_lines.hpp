#pragma once
/// The lines of a Wavefront OBJ that a reader wants.

#include <cstddef>
#include <span>
#include <string_view>

#include "slicer/reader/records/record_text.hpp"
#include "slicer/reader/stream/line_input.hpp"
#include "slicer/reader/stream/words.hpp"

namespace plumbline::inline slicer {

/// Joins lines that a backslash continues, and skips those that nobody wants, whatever their length.
class ObjLines {
 public:
  /// Bytes: the longest line that may be continued over several. Six numbers take some 150, a face of three corners 60.
  static constexpr std::size_t kLongestJoined = 4096;

  /// @param joined  kLongestJoined bytes
  ObjLines(ByteInput& input, std::span<char> joined) : lines_(input), joined_(joined) {}

  /// @param wanted  bool(keyword)
  /// @returns false at the end of the file
  /// @retval ErrorCode::kUnsupported  a wanted line is continued over more than kLongestJoined bytes
  template <class Wanted>
  [[nodiscard]] Expected<bool> next(Wanted wanted) {
    for (;;) {
      const auto found = lines_.next(line_);
      PLUMBLINE_TRY(found);
      if (!*found) return false;
      keyword_ = LineWords(line_.text).next();
      if (wanted(keyword_)) {
        if (is_continued()) PLUMBLINE_TRY(join());
        split();
        return true;
      }
      if (keyword_.find('\0') != std::string_view::npos && !line_.unterminated) return fail_zeros(lines_);
      // Comments are not continued: "# C:\scans\" would swallow the vertex on the next line.
      if (keyword_.empty() || keyword_.front() != '#') PLUMBLINE_TRY(skip_continuation());
    }
  }

  std::string_view keyword() const { return keyword_; }
  std::string_view rest() const { return rest_; }  ///< of the line, after the keyword
  const Line& line() const { return line_; }
  const LineInput& lines() const { return lines_; }

 private:
  bool is_continued() const { return !line_.text.empty() && line_.text.back() == '\\'; }
  void split();
  Status join();
  Status skip_continuation();

  LineInput lines_;
  std::span<char> joined_;
  Line line_;
  std::string_view keyword_;
  std::string_view rest_;
};

}  // namespace plumbline::inline slicer
