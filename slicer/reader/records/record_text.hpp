#pragma once
/// Reads records of a text file, one a line.

#include <cstdint>
#include <string_view>

#include "slicer/reader/records/record.hpp"
#include "slicer/reader/stream/line_input.hpp"
#include "slicer/reader/stream/words.hpp"

namespace plumbline {

struct RowOutcome {
  enum class Kind : std::uint8_t { kWhole, kTooFew, kNotANumber };
  Kind kind = Kind::kWhole;
  std::string_view word = {};  ///< what was found instead of a number
  const char* wanted = "";     ///< what was expected: "x"
};

/// Parses one row of numbers. Words after the layout's last step are ignored. A list at the very end may be missing: some
/// exporters leave out an empty list together with its count.
[[nodiscard]] RowOutcome parse_row(std::string_view text, const RecordLayout& layout, const Separators& separators,
                                   SlotValues& row);

/// The error for a row that is not whole. kTruncated if the file ended before the line did.
/// @param line  as from LineInput, or with `text` joined from several lines
tl::unexpected<Error> fail_row(const LineInput& lines, const Line& line, const RowOutcome& outcome);
/// The last line has bytes that are zero, as a failing stick or a broken copy leaves them.
tl::unexpected<Error> fail_zeros(const LineInput& lines);

/// Reads `count` rows as points, ignoring empty lines.
/// @retval ErrorCode::kTruncated, kMalformed
/// @retval ErrorCode::kUnsupported  a row is longer than the window
[[nodiscard]] Status read_text_points(LineInput& lines, const RecordLayout& layout, std::uint64_t count,
                                      PointBatch& batch);

/// Skips `count` rows of any length.
[[nodiscard]] Status skip_text_records(LineInput& lines, std::uint64_t count);

/// Whether a line has nothing but blanks.
bool is_blank(std::string_view text);

}  // namespace plumbline
