#include <algorithm>
#include <array>
#include <cmath>
#include <cstring>

#include "slicer/core/words/plural.hpp"
#include "slicer/reader/formats/scan_formats.hpp"
#include "slicer/reader/formats/splats/splat_filter.hpp"
#include "slicer/reader/stream/inflate_stream.hpp"
#include "slicer/reader/stream/number.hpp"

namespace plumbline::inline slicer {
namespace {

constexpr const char* kStage = "reading SPZ";

constexpr std::size_t kHeadBytes = 16;
constexpr std::size_t kPosition = 9;      ///< bytes of a splat: three integers of 24 bits
constexpr std::size_t kHalfPosition = 6;  ///< of version 1: three floats of 16 bits
constexpr std::size_t kScales = 3;
constexpr std::size_t kColours = 3;
/// Bytes of the colours that depend on the view, by their degree.
constexpr std::array<std::uint64_t, 5> kHarmonics = {0, 9, 24, 45, 72};
constexpr unsigned kHasExtensions = 2;  ///< flag: more follows the splats
/// Faintest opacity that is kept, of 255; the logit is not needed.
constexpr unsigned kFaintestByte = 77;

unsigned byte_at(std::span<const char> bytes, std::size_t at) { return static_cast<unsigned char>(bytes[at]); }

std::uint32_t load32(std::span<const char> bytes, std::size_t at) {
  return byte_at(bytes, at) | byte_at(bytes, at + 1) << 8 | byte_at(bytes, at + 2) << 16 | byte_at(bytes, at + 3) << 24;
}

/// A float of 16 bits (IEEE 754).
double half_of(unsigned bits) {
  const unsigned exponent = bits >> 10 & 31U;
  const double fraction = bits & 1023U;
  const double size = exponent == 31  ? HUGE_VAL
                      : exponent == 0 ? std::ldexp(fraction, -24)
                                      : std::ldexp(1024 + fraction, static_cast<int>(exponent) - 25);
  return (bits & 0x8000U) != 0 ? -size : size;
}

/// The file has all positions, then all opacities, colours, radii and rotations (github.com/nianticlabs/spz). Positions, opacities and
/// radii are kept until the rotations come.
class SpzReader {
 public:
  SpzReader(ByteInput& input, PointBatch& batch, InflateStream& stream)
      : input_(input), batch_(batch), stream_(stream) {}

  Status read(Arena& columns) {
    PLUMBLINE_TRY(read_header());
    const std::uint64_t need = 3 * Arena::kAlignment + saturating_multiply(points_, position_ + 1 + kScales);
    PLUMBLINE_TRY(batch_.begin({.format = ScanFormat::kSpz,
                                .encoding = "gzip splats",
                                .has_normals = true,
                                .has_unsigned_normals = true,
                                .declared_points = points_,
                                .is_packed = true,
                                .reader_bytes = need}));
    if (need > columns.available()) {
      return input_.fail(ErrorCode::kUnsupported,
                         "SPZ stores its columns one after another; keeping those of %llu splats takes %llu bytes, but "
                         "%zu are free.\tSave the splats as PLY",
                         shown(points_), shown(need), columns.available());
    }
    const auto count = static_cast<std::size_t>(points_);
    const auto positions = columns.take_bottom<char>(count * position_, kStage);
    PLUMBLINE_TRY(positions);
    const auto opacities = columns.take_bottom<char>(count, kStage);
    PLUMBLINE_TRY(opacities);
    const auto scales = columns.take_bottom<char>(count * kScales, kStage);
    PLUMBLINE_TRY(scales);
    PLUMBLINE_TRY(fill(*positions));
    PLUMBLINE_TRY(fill(*opacities));
    PLUMBLINE_TRY(skip(points_ * kColours));
    PLUMBLINE_TRY(fill(*scales));
    PLUMBLINE_TRY(deliver(*positions, *opacities, *scales));
    PLUMBLINE_TRY(skip(points_ * kHarmonics[degree_]));
    return has_extensions_ ? Status() : check_end_of_columns();
  }

 private:
  static unsigned long long shown(std::uint64_t number) { return static_cast<unsigned long long>(number); }

  Status read_header() {
    std::array<char, kHeadBytes> head = {};
    std::size_t filled = 0;
    while (filled < head.size()) {
      const auto piece = stream_.next(head.size() - filled);
      if (!piece && piece.error().code() != ErrorCode::kMalformed && piece.error().code() != ErrorCode::kTruncated) {
        return tl::unexpected<Error>(piece.error());
      }
      if (!piece || piece->empty()) break;
      std::memcpy(head.data() + filled, piece->data(), piece->size());
      filled += piece->size();
    }
    if (filled < head.size() || std::memcmp(head.data(), "NGSP", 4) != 0) {
      return input_.fail(ErrorCode::kUnknownFormat, "this is a gzip archive;\tunpack it and give the scan inside");
    }
    version_ = load32(head, 4);
    points_ = load32(head, 8);
    const unsigned fraction_bits = byte_at(head, 13);
    if (version_ < 1 || version_ > 3) {
      return input_.fail(ErrorCode::kUnsupported,
                         "SPZ of version %u is not supported;\texport it as version 3, or as PLY", version_);
    }
    if (fraction_bits > 24) {
      return input_.fail(ErrorCode::kMalformed,
                         "positions of 24 bits with %u after the point; the file is damaged.\tExport it again",
                         fraction_bits);
    }
    if (points_ == 0) return input_.fail(ErrorCode::kNoPoints, "the file has no splats;\texport it again");
    unit_ = 1.0 / static_cast<double>(1U << fraction_bits);
    rotation_bytes_ = version_ == 3 ? 4 : 3;
    position_ = version_ == 1 ? kHalfPosition : kPosition;
    degree_ = byte_at(head, 12);
    if (degree_ >= kHarmonics.size()) {
      return input_.fail(ErrorCode::kMalformed,
                         "colours of degree %u, where 4 is the highest; the file is damaged.\tExport it again",
                         degree_);
    }
    has_extensions_ = (byte_at(head, 14) & kHasExtensions) != 0;
    // Not even the best compression makes so many splats from so few bytes.
    const auto size = input_.size();
    if (size && points_ * splat_bytes() > saturating_multiply(*size, InflateStream::kLargestRatio)) {
      return input_.fail(ErrorCode::kTruncated,
                         "%llu bytes can't hold the %llu splat%s that the header declares;\tcopy or export it again",
                         shown(*size), shown(points_), plural_s(points_));
    }
    return {};
  }

  std::uint64_t splat_bytes() const { return position_ + 1 + kColours + kScales + rotation_bytes_; }

  /// With more splats than the header declares, the bytes of one column would be read as the next one.
  Status check_end_of_columns() {
    for (std::uint64_t left = 0;;) {
      const auto piece = stream_.next(splat_bytes());
      PLUMBLINE_TRY(piece);
      if (piece->empty()) return {};
      left += piece->size();
      if (left >= splat_bytes()) {
        return input_.fail(ErrorCode::kMalformed,
                           "its header declares %llu splats, but the data has more;\texport the file again",
                           shown(points_));
      }
    }
  }

  template <class Use>
  Status take(std::uint64_t bytes, Use&& use) {
    while (bytes > 0) {
      const auto piece = stream_.next(bytes);
      PLUMBLINE_TRY(piece);
      if (piece->empty()) {
        return input_.fail(
            ErrorCode::kTruncated,
            "the compressed data is too short for the %llu splats that its header declares;\texport the file again",
            shown(points_));
      }
      use(*piece);
      bytes -= piece->size();
    }
    return {};
  }
  Status fill(std::span<char> to) {
    return take(to.size(), [&](std::span<const char> piece) {
      std::memcpy(to.data(), piece.data(), piece.size());
      to = to.subspan(piece.size());
    });
  }
  Status skip(std::uint64_t bytes) {
    return take(bytes, [](std::span<const char>) {});
  }

  double coordinate(std::span<const char> bytes, std::size_t at) const {
    if (version_ == 1) return half_of(byte_at(bytes, at) | byte_at(bytes, at + 1) << 8);
    const std::uint32_t raw = byte_at(bytes, at) << 8 | byte_at(bytes, at + 1) << 16 | byte_at(bytes, at + 2) << 24;
    const std::int32_t units = static_cast<std::int32_t>(raw) / 256;
    return units * unit_;
  }

  /// A radius r is stored as 16 (ln r + 10).
  static double scale_of(unsigned byte) { return byte / 16.0 - 10; }
  static double opacity_of(unsigned byte) {
    return byte >= kFaintestByte ? SplatFilter::kFaintest : SplatFilter::kFaintest - 1;
  }

  /// Versions 1 and 2: x, y, z as 127.5 (v + 1), and w >= 0 such that the length is 1. Version 3: the largest component is left out and positive,
  /// the two highest bits say which it is; the others follow from the highest bits down as sign and 9 bits of |v| sqrt(2) * 511.
  void set_turn(std::span<const char> bytes, SlotValues& row) const {
    std::array<double, 4> q = {};  // x, y, z, w
    double square = 0;
    std::size_t missing = 3;
    if (version_ != 3) {
      for (std::size_t i = 0; i < 3; ++i) q[i] = byte_at(bytes, i) / 127.5 - 1;
    } else {
      std::uint32_t packed = load32(bytes, 0);
      missing = packed >> 30;
      for (std::size_t i = 4; i-- > 0;) {
        if (i == missing) continue;
        const double size = (packed & 511U) / (511 * 1.41421356237309504880);
        q[i] = (packed & 512U) != 0 ? -size : size;
        packed >>= 10;
      }
    }
    for (const double v : q) square += v * v;
    q[missing] = std::sqrt(std::max(0.0, 1 - square));
    row[kTurn] = q[3];
    for (std::size_t i = 0; i < 3; ++i) row[kTurn + 1 + i] = q[i];
  }

  Status deliver(std::span<const char> positions, std::span<const char> opacities, std::span<const char> scales) {
    SplatFilter filter;
    for (std::size_t i = 0; i < opacities.size(); ++i) {
      unsigned longest = 0;
      for (std::size_t a = 0; a < kScales; ++a) longest = std::max(longest, byte_at(scales, kScales * i + a));
      filter.survey(opacity_of(byte_at(opacities, i)), scale_of(longest));
    }
    filter.end_survey();
    batch_.filter_by(&filter);
    const Status delivered = deliver_rows(positions, opacities, scales);
    batch_.filter_by(nullptr);
    return delivered;
  }

  Status deliver_rows(std::span<const char> positions, std::span<const char> opacities, std::span<const char> scales) {
    SlotValues row = {};
    std::array<char, 4> turn = {};
    for (std::size_t i = 0; i < opacities.size(); ++i) {
      PLUMBLINE_TRY(fill(std::span(turn).first(rotation_bytes_)));
      for (std::size_t a = 0; a < 3; ++a) {
        row[kX + a] = coordinate(positions, position_ * i + position_ / 3 * a);
        row[kScale + a] = scale_of(byte_at(scales, kScales * i + a));
      }
      row[kOpacity] = opacity_of(byte_at(opacities, i));
      set_turn(turn, row);
      batch_.add(row);
      if (batch_.full()) PLUMBLINE_TRY(batch_.flush());
    }
    return {};
  }

  ByteInput& input_;
  PointBatch& batch_;
  InflateStream& stream_;
  unsigned version_ = 0;
  std::uint64_t points_ = 0;
  double unit_ = 1;
  unsigned degree_ = 0;  ///< of colours
  bool has_extensions_ = false;
  std::size_t rotation_bytes_ = 0;
  std::size_t position_ = kPosition;  ///< bytes of x, y and z
};

}  // namespace

Status read_spz(ByteInput& input, PointBatch& batch, Arena& memory, Arena& columns) {
  const auto window = memory.take_bottom<char>(InflateStream::kWindow, kStage);
  PLUMBLINE_TRY(window);
  const auto heap = memory.take_bottom<std::byte>(InflateStream::kHeap, kStage);
  PLUMBLINE_TRY(heap);
  InflateStream stream(input, InflateStream::Wrapping::kGzip, *window, *heap);
  return SpzReader(input, batch, stream).read(columns);
}

}  // namespace plumbline::inline slicer
