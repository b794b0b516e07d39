#pragma once
/// Records of a text: one a line.

#include <cstdint>
#include <string_view>

#include "slicer/reader/records/record.hpp"
#include "slicer/reader/stream/line_input.hpp"
#include "slicer/reader/stream/words.hpp"

namespace plumbline {

struct RowOutcome {
  enum class Kind : std::uint8_t { kWhole, kTooFew, kNotANumber };
  Kind kind = Kind::kWhole;
  std::string_view word = {};  ///< what stands where a number must
  const char* wanted = "";     ///< what that number would have been: "x"
};

/// One row of numbers. Numbers behind the last one of the layout do not matter. A list at the very end may be missing
/// altogether: some exporters leave out an empty one together with its count.
[[nodiscard]] RowOutcome parse_row(std::string_view text, const RecordLayout& layout, const Separators& separators,
                                   SlotValues& row);

/// The error of a row that is not whole. A row that ends with the file rather than with its line was cut off:
/// kTruncated.
/// @param line  as LineInput gave it, or with `text` put together from several
tl::unexpected<Error> fail_row(const LineInput& lines, const Line& line, const RowOutcome& outcome);

/// `count` rows as points; empty lines do not count.
/// @retval ErrorCode::kTruncated, kMalformed, kUnsupported  the last for a row longer than the window
[[nodiscard]] Status read_text_points(LineInput& lines, const RecordLayout& layout, std::uint64_t count,
                                      PointBatch& batch);

/// Goes past `count` rows of any length.
[[nodiscard]] Status skip_text_records(LineInput& lines, std::uint64_t count);

/// Nothing but blanks.
bool is_blank(std::string_view text);

}  // namespace plumbline
