#pragma once
/// Reads records of a text file.

#include <cstdint>
#include <string_view>

#include "slicer/reader/records/record.hpp"
#include "slicer/reader/stream/line_input.hpp"
#include "slicer/reader/stream/words.hpp"

namespace plumbline::inline slicer {

struct RowOutcome {
  enum class Kind : std::uint8_t { kWhole, kTooFew, kNotANumber, kOtherCells };
  Kind kind = Kind::kWhole;
  std::string_view word = {};  ///< what was found instead of a number
  const char* wanted = "";     ///< what was expected: "x"
};

/// Whether a line has nothing but blanks.
bool is_blank(std::string_view text);

/// Of the number in a slot, for RowOutcome::wanted.
const char* slot_name(std::size_t slot);

/// Parses one row of numbers. Words after the layout's last step are ignored. A list at the very end may be missing: some
/// exporters leave out an empty list together with its count.
/// @param end  if not null, set to the byte behind the last step of a row that is whole
[[nodiscard]] RowOutcome parse_row(std::string_view text, const RecordLayout& layout, const Separators& separators,
                                   SlotValues& row, const char** end = nullptr);

/// The error for a row that is not whole. kTruncated if the file ended before the line did.
/// @param line  as from LineInput, or with `text` joined from several lines
tl::unexpected<Error> fail_row(const LineInput& lines, const Line& line, const RowOutcome& outcome);
/// The last line has bytes that are zero, as a failing stick or a broken copy leaves them.
tl::unexpected<Error> fail_zeros(const LineInput& lines);

/// Records of a PLY text, by words: a record may go on in the next line, and a line may have several.
class TextRecords {
 public:
  explicit TextRecords(LineInput& lines) : lines_(lines) {}

  /// Reads the next record; a list at its end may be missing if the line ends there.
  /// @returns false at the end of the file
  /// @retval ErrorCode::kTruncated, kMalformed
  /// @retval ErrorCode::kUnsupported  a word is longer than the window
  [[nodiscard]] Expected<bool> next(const RecordLayout& layout, SlotValues& row);
  /// Takes the next word, empty at the end of the file.
  [[nodiscard]] Expected<std::string_view> next_word();

  /// Reads `count` records as points.
  /// @retval as next(); also kTruncated if there are fewer
  [[nodiscard]] Status read_points(const RecordLayout& layout, std::uint64_t count, PointBatch& batch);
  /// Skips `count` records.
  /// @param what  they are, in the plural
  [[nodiscard]] Status skip(const RecordLayout& layout, std::uint64_t count, const char* what);
  /// Tests that nothing but words is left.
  /// @param what   the last records, in the plural
  [[nodiscard]] Status check_end(const char* what, std::uint64_t count);

  bool is_line_end() const { return is_blank(rest_) && !line_.cut; }
  /// Whether records and lines don't end together. Rows that don't fit their header look the same: what follows must be read to tell.
  bool is_loose() const { return is_loose_ || !is_line_end(); }

  const LineInput& lines() const { return lines_; }
  const Line& line() const { return line_; }

 private:
  Expected<bool> next_line();
  Expected<bool> next_by_words(const RecordLayout& layout, SlotValues& row);

  LineInput& lines_;
  Line line_;
  std::string_view rest_;  ///< of line_
  bool is_loose_ = false;  ///< a record had a line end within, and began or ended within a line
};

/// Reads `count` rows as points, one a line, ignoring empty lines.
/// @retval ErrorCode::kTruncated, kMalformed
/// @retval ErrorCode::kUnsupported  a row is longer than the window
[[nodiscard]] Status read_text_points(LineInput& lines, const RecordLayout& layout, std::uint64_t count,
                                      PointBatch& batch);

}  // namespace plumbline::inline slicer
