#include <algorithm>
#include <array>
#include <cmath>
#include <limits>

#include "slicer/core/words/plural.hpp"
#include "slicer/reader/formats/scan_formats.hpp"
#include "slicer/reader/records/record.hpp"
#include "slicer/reader/records/records_end.hpp"

namespace plumbline::inline slicer {
namespace {

/// Bytes of a point of formats 0 to 10 (LAS 1.4 R15, tables 7 to 21). A record may have extra bytes after them.
constexpr std::array<std::size_t, 11> kPointBytes = {20, 28, 26, 34, 57, 63, 30, 36, 38, 59, 67};

/// Bytes of the header up to the bounding box, the same in all versions.
constexpr std::size_t kHeadBytes = 227;
constexpr std::size_t kHeadBytes13 = 235;
constexpr std::size_t kHeadBytes14 = 375;

/// Classes of the ASPRS that mark a point as noise.
constexpr unsigned kLowNoise = 7;
constexpr unsigned kHighNoise = 18;

template <class T>
T load(const char* bytes, std::size_t at) {
  T number;
  std::memcpy(&number, bytes + at, sizeof number);
  if constexpr (std::endian::native == std::endian::big && sizeof(T) > 1) {
    char* const first = reinterpret_cast<char*>(&number);
    std::reverse(first, first + sizeof number);
  }
  return number;
}

struct LasHeader {
  unsigned minor = 0;                                                    ///< of version 1.minor
  unsigned format = 0;                                                   ///< of the points
  std::size_t record = 0;                                                ///< bytes of a point
  std::uint64_t points = 0;                                              ///< declared
  std::uint64_t points_at = 0;                                           ///< byte of the file
  std::uint64_t points_end = std::numeric_limits<std::uint64_t>::max();  ///< where something else may begin
  std::array<double, 3> scale = {};                                      ///< coordinate = scale * integer + offset
  std::array<double, 3> offset = {};
};

class LasReader {
 public:
  LasReader(ByteInput& input, PointBatch& batch) : input_(input), batch_(batch) {}

  Status read() {
    PLUMBLINE_TRY(read_header());
    PLUMBLINE_TRY(check_header());
    PLUMBLINE_TRY(batch_.begin({.format = ScanFormat::kLas,
                                .encoding = "binary little endian",
                                .has_normals = false,
                                .declared_points = header_.points}));
    const std::uint64_t gap = header_.points_at - input_.offset();
    const auto skipped = input_.skip(gap);
    PLUMBLINE_TRY(skipped);
    if (*skipped < gap) return fail_truncated(0);
    return read_points();
  }

 private:
  Status read_header() {
    auto ready = input_.fill(kHeadBytes);
    PLUMBLINE_TRY(ready);
    if (*ready < kHeadBytes) {
      return input_.fail(ErrorCode::kTruncated,
                         "the file ends at byte %zu, in its header of %zu bytes;\tcopy or export it again", *ready,
                         kHeadBytes);
    }
    const char* head = input_.begin();
    const unsigned major = load<std::uint8_t>(head, 24);
    header_.minor = load<std::uint8_t>(head, 25);
    if (major != 1 || header_.minor > 4) {
      return input_.fail(ErrorCode::kUnsupported, "byte 24: LAS %u.%u is not supported;\texport it as LAS 1.0 to 1.4",
                         major, header_.minor);
    }
    head_bytes_ = load<std::uint16_t>(head, 94);
    header_.points_at = load<std::uint32_t>(head, 96);
    header_.format = load<std::uint8_t>(head, 104);
    header_.record = load<std::uint16_t>(head, 105);
    header_.points = load<std::uint32_t>(head, 107);
    for (std::size_t a = 0; a < 3; ++a) {
      header_.scale[a] = load<double>(head, 131 + 8 * a);
      header_.offset[a] = load<double>(head, 155 + 8 * a);
    }
    if (header_.minor < 3 || head_bytes_ < kHeadBytes13) return {};
    ready = input_.fill(kHeadBytes13);
    PLUMBLINE_TRY(ready);
    if (*ready >= kHeadBytes13) set_end(load<std::uint64_t>(input_.begin(), 227));  // waveforms
    if (header_.minor < 4 || head_bytes_ < kHeadBytes14) return {};
    ready = input_.fill(kHeadBytes14);
    PLUMBLINE_TRY(ready);
    if (*ready < kHeadBytes14) {
      return input_.fail(ErrorCode::kTruncated,
                         "the file ends at byte %zu, in its header of %zu bytes;\tcopy or export it again", *ready,
                         kHeadBytes14);
    }
    // The 32-bit count is 0 where the points' format or number is too new for it.
    const auto points = load<std::uint64_t>(input_.begin(), 247);
    if (points != 0) header_.points = points;
    if (load<std::uint32_t>(input_.begin(), 243) != 0) set_end(load<std::uint64_t>(input_.begin(), 235));  // records
    return {};
  }

  /// @param at  byte of the file that a header names; 0: there is no such thing
  void set_end(std::uint64_t at) {
    if (at != 0) header_.points_end = std::min(header_.points_end, at);
  }

  Status check_header() const {
    if ((header_.format & 0xC0U) != 0) {
      return telling(
          Told(ToldCode::kLaz, {}, input_.name()),
          input_.fail(ErrorCode::kUnsupported,
                      "this is LAZ, which is compressed;\tsave it as LAS with the program that wrote it, with "
                      "CloudCompare, or with 'laszip -i scan.laz -o scan.las'"));
    }
    if (header_.format >= kPointBytes.size()) {
      return input_.fail(
          ErrorCode::kUnsupported,
          "byte 104: point format %u is not supported;\texport the file with a point format from 0 to 10",
          header_.format);
    }
    if (header_.record < kPointBytes[header_.format]) {
      return input_.fail(ErrorCode::kMalformed,
                         "byte 105: points of %zu byte%s, but format %u has at least %zu; the file is damaged.\tExport "
                         "it again",
                         header_.record, plural_s(header_.record), header_.format, kPointBytes[header_.format]);
    }
    if (head_bytes_ < kHeadBytes || header_.points_at < head_bytes_) {
      return input_.fail(
          ErrorCode::kMalformed,
          "byte 94: a header of %zu bytes with points at byte %llu; the file is damaged.\tExport it again", head_bytes_,
          static_cast<unsigned long long>(header_.points_at));
    }
    for (std::size_t a = 0; a < 3; ++a) {
      if (std::isfinite(header_.scale[a]) && std::isfinite(header_.offset[a]) && header_.scale[a] != 0) continue;
      return input_.fail(ErrorCode::kMalformed,
                         "byte %zu: the scale %g or the offset %g of %c is not usable; the file is damaged.\tExport it "
                         "again",
                         131 + 8 * a, header_.scale[a], header_.offset[a], static_cast<char>('x' + a));
    }
    return {};
  }

  tl::unexpected<Error> fail_truncated(std::uint64_t read) const {
    return input_.fail(
        ErrorCode::kTruncated,
        "the file ends at byte %llu, with %llu of the %llu points that its header declares;\tcopy or export it again",
        static_cast<unsigned long long>(input_.bytes_read()), static_cast<unsigned long long>(read),
        static_cast<unsigned long long>(header_.points));
  }

  /// Whether a point is deleted (withheld), or noise.
  bool is_unwanted(const char* point) const {
    if (header_.format >= 6) {
      const unsigned point_class = load<std::uint8_t>(point, 16);
      return (load<std::uint8_t>(point, 15) & 4U) != 0 || point_class == kLowNoise || point_class == kHighNoise;
    }
    const unsigned marks = load<std::uint8_t>(point, 15);
    // In LAS 1.0 the upper three bits are not defined.
    return (marks & 31U) == kLowNoise || (header_.minor > 0 && (marks & 128U) != 0);
  }

  Status read_points() {
    SlotValues row = {};
    for (std::uint64_t done = 0; done < header_.points;) {
      const auto ready = input_.fill(header_.record);
      PLUMBLINE_TRY(ready);
      if (*ready < header_.record) return fail_truncated(done);
      const std::uint64_t whole = std::min<std::uint64_t>(header_.points - done, *ready / header_.record);
      for (std::uint64_t i = 0; i < whole; ++i) {
        const char* const point = input_.begin();
        input_.consume(header_.record);
        if (is_unwanted(point)) {
          batch_.leave_out();
          continue;
        }
        for (std::size_t a = 0; a < 3; ++a) {
          row[a] = static_cast<double>(load<std::int32_t>(point, 4 * a)) * header_.scale[a] + header_.offset[a];
        }
        batch_.add(row);
        if (batch_.full()) PLUMBLINE_TRY(batch_.flush());
      }
      done += whole;
    }
    const std::uint64_t room = header_.points_end - std::min(header_.points_end, input_.offset());
    return check_end(input_, "points", header_.points, header_.record, room);
  }

  ByteInput& input_;
  PointBatch& batch_;
  LasHeader header_;
  std::size_t head_bytes_ = 0;
};

}  // namespace

Status read_las(ByteInput& input, PointBatch& batch) { return LasReader(input, batch).read(); }

}  // namespace plumbline::inline slicer
