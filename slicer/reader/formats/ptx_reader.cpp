#include <array>
#include <cassert>
#include <cmath>
#include <optional>

#include "slicer/reader/formats/scan_formats.hpp"
#include "slicer/reader/records/record_text.hpp"
#include "slicer/reader/records/scan_pose.hpp"
#include "slicer/reader/stream/number.hpp"

namespace plumbline::inline slicer {
namespace {

/// Each scan has two lines with its columns and rows, four with the scanner's place and axes, four with the transform to the
/// common frame, and a line "x y z intensity [r g b]" for each point, in the scanner's frame.
class PtxReader {
 public:
  PtxReader(ByteInput& input, PointBatch& batch) : lines_(input), batch_(batch) {
    for (const std::size_t slot : {kX, kY, kZ}) {
      [[maybe_unused]] const bool fits = three_.add_field(ScalarType::kDouble, slot);
      assert(fits);
    }
  }

  Status read() {
    for (bool first = true;; first = false) {
      const auto found = next();
      PLUMBLINE_TRY(found);
      if (!*found) return {};
      PLUMBLINE_TRY(read_size());
      const std::uint64_t points = saturating_multiply(columns_, rows_);
      if (first) {
        PLUMBLINE_TRY(batch_.begin({.format = ScanFormat::kPtx,
                                    .encoding = "ascii",
                                    .has_normals = false,
                                    .has_views = true,
                                    .declared_points = points}));
      }
      PLUMBLINE_TRY(read_place());
      PLUMBLINE_TRY(read_pose());
      PLUMBLINE_TRY(batch_.begin_view({.scanner = scanner()}));
      PLUMBLINE_TRY(read_points(points));
    }
  }

 private:
  unsigned long long number() const { return static_cast<unsigned long long>(lines_.number()); }

  /// Goes to the next line that is not empty.
  Expected<bool> next() {
    for (;;) {
      const auto found = lines_.next(line_);
      if (!found || !*found || line_.cut || !is_blank(line_.text)) return found;
    }
  }

  Status need_next(const char* what) {
    const auto found = next();
    PLUMBLINE_TRY(found);
    if (*found) return {};
    return lines_.input().fail(ErrorCode::kTruncated,
                               "the file ends after line %llu, before %s of a scan;\tcopy or export it again", number(),
                               what);
  }

  /// Parses the current line as one whole number.
  Expected<std::uint64_t> read_count(const char* what) {
    LineWords words(line_.text);
    const auto count = parse_count(words.next());
    if (count && words.next().empty()) return *count;
    return lines_.input().fail(
        ErrorCode::kMalformed,
        "line %llu: expected the number of %s of a scan, found '%s';\tcorrect the line or export the file again",
        number(), what, Quote(line_.text).c_str());
  }

  Status read_size() {
    const auto columns = read_count("columns");
    PLUMBLINE_TRY(columns);
    PLUMBLINE_TRY(need_next("the rows"));
    const auto rows = read_count("rows");
    PLUMBLINE_TRY(rows);
    columns_ = *columns;
    rows_ = *rows;
    return {};
  }

  Status read_numbers(std::span<double> numbers, const char* what) {
    PLUMBLINE_TRY(need_next(what));
    LineWords words(line_.text);
    for (double& number : numbers) {
      const auto word = words.next();
      const char* const end = word.data() + word.size();
      if (!word.empty() && parse_real(word.data(), end, number) == end && std::isfinite(number)) continue;
      return lines_.input().fail(ErrorCode::kMalformed,
                                 "line %llu: expected %zu numbers for %s, found '%s';\tcorrect the line or export the "
                                 "file again",
                                 this->number(), numbers.size(), what, Quote(line_.text).c_str());
    }
    return {};
  }

  /// The scanner's place, and its axes, which the transform has too.
  Status read_place() {
    for (int line = 0; line < 4; ++line) {
      PLUMBLINE_TRY(read_numbers(std::span(numbers_).first(3), "the scanner's axes"));
      if (line == 0) place_ = {numbers_[0], numbers_[1], numbers_[2]};
    }
    return {};
  }

  /// The scanner stands at the origin of its scan, which the transform moves to the place that the header states. Where points are already in
  /// the common frame, only that place tells. A list without rows and columns, with everything at 0, is a merged cloud.
  std::optional<Vec3d> scanner() const {
    if (pose_.translation != Vec3d::Zero()) return pose_.translation;
    if (place_ == Vec3d::Zero() && (columns_ < 2 || rows_ < 2)) return std::nullopt;
    return place_;
  }

  /// The transform is for row vectors: p' = p M, with the translation in the last row.
  Status read_pose() {
    for (int row = 0; row < 4; ++row) {
      PLUMBLINE_TRY(read_numbers(numbers_, "the scan's transform"));
      for (int column = 0; column < 3; ++column) {
        const double value = numbers_[static_cast<std::size_t>(column)];
        (row < 3 ? pose_.rotation(column, row) : pose_.translation[column]) = value;
      }
      if (numbers_[3] == (row < 3 ? 0 : 1)) continue;
      return lines_.input().fail(
          ErrorCode::kUnsupported,
          "line %llu: the last column of a scan's transform must be 0 0 0 1, found '%s';\texport "
          "the file again",
          number(), Quote(line_.text).c_str());
    }
    if (pose_.rotation.determinant() != 0) return {};
    return lines_.input().fail(ErrorCode::kMalformed,
                               "line %llu: the scan's transform makes it flat;\texport the file again", number());
  }

  Status read_points(std::uint64_t count) {
    SlotValues row = {};
    for (std::uint64_t done = 0; done < count;) {
      const auto found = lines_.next(line_);
      PLUMBLINE_TRY(found);
      if (!*found) {
        return lines_.input().fail(
            ErrorCode::kTruncated,
            "the file ends after line %llu, with %llu of the %llu points of a scan;\tcopy or export it again", number(),
            static_cast<unsigned long long>(done), static_cast<unsigned long long>(count));
      }
      const RowOutcome outcome = parse_row(line_.text, three_, kBlanks, row);
      if (outcome.kind != RowOutcome::Kind::kWhole) {
        if (!line_.cut && is_blank(line_.text)) continue;
        return fail_row(lines_, line_, outcome);
      }
      ++done;
      if (row[kX] == 0 && row[kY] == 0 && row[kZ] == 0) {
        batch_.leave_out();
        continue;
      }
      pose_.apply(row);
      batch_.add(row);
      if (batch_.full()) PLUMBLINE_TRY(batch_.flush());
    }
    return {};
  }

  LineInput lines_;
  PointBatch& batch_;
  RecordStep steps_[3];
  RecordLayout three_{steps_};
  Line line_;
  std::uint64_t columns_ = 0, rows_ = 0;
  Vec3d place_ = Vec3d::Zero();
  ScanPose pose_;
  std::array<double, 4> numbers_ = {};
};

}  // namespace

Status read_ptx(ByteInput& input, PointBatch& batch) { return PtxReader(input, batch).read(); }

}  // namespace plumbline::inline slicer
