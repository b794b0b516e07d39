#include <algorithm>
#include <array>
#include <cmath>
#include <limits>

#include "slicer/core/numbers/degrees.hpp"
#include "slicer/reader/formats/e57/e57_pages.hpp"
#include "slicer/reader/formats/e57/e57_streams.hpp"
#include "slicer/reader/formats/e57/e57_xml.hpp"
#include "slicer/reader/formats/format_probe.hpp"
#include "slicer/reader/formats/scan_formats.hpp"
#include "slicer/reader/stream/number.hpp"

namespace plumbline::inline slicer {
namespace {

constexpr double kMmPerMetre = 1000;
constexpr double kDegreesPerRadian = 57.295779513082320877;

/// Share of the progress that the first pass takes. It only looks for the XML section, most of the file is read twice.
constexpr double kFirstPass = 0.5;

/// Larger than the XML of any scan: a hostile file must not keep the parser busy for hours.
constexpr std::uint64_t kMostXmlBytes = std::uint64_t{64} << 20U;

template <class T>
T load(std::span<const char> bytes, std::size_t at) {
  T number = 0;
  for (std::size_t i = 0; i < sizeof(T); ++i) {
    number =
        static_cast<T>(number | static_cast<T>(static_cast<T>(static_cast<unsigned char>(bytes[at + i])) << (8 * i)));
  }
  return number;
}

/// (ASTM E2807, 7.5.2) range, azimuth, elevation in m and radians to x, y, z.
void to_cartesian(std::array<double, kE57Slots>& values) {
  const double range = values[kE57X];
  const double azimuth = values[kE57Y] * kDegreesPerRadian;
  const double elevation = values[kE57Z] * kDegreesPerRadian;
  constexpr double kManyTurns = 1e6;
  if (!(std::abs(azimuth) < kManyTurns && std::abs(elevation) < kManyTurns)) {
    values[kE57X] = std::numeric_limits<double>::quiet_NaN();
    return;
  }
  const auto [sin_a, cos_a] = sine_cosine(azimuth);
  const auto [sin_e, cos_e] = sine_cosine(elevation);
  values[kE57X] = range * cos_e * cos_a;
  values[kE57Y] = range * cos_e * sin_a;
  values[kE57Z] = range * sin_e;
}

class E57Reader {
 public:
  E57Reader(ByteInput& input, PointBatch& batch, Arena& memory)
      : input_(input), pages_(input), batch_(batch), memory_(memory) {}

  Status read() {
    input_.report_within(0, kFirstPass);
    PLUMBLINE_TRY(read_header());
    PLUMBLINE_TRY(pages_.seek(xml_at_));
    const auto scans = read_e57_xml(pages_, xml_bytes_, memory_);
    PLUMBLINE_TRY(scans);
    if (scans->empty()) {
      return input_.fail(ErrorCode::kNoPoints, "the file has no points with coordinates;\texport the scan again");
    }
    ScanHeader header{.format = ScanFormat::kE57,
                      .encoding = "bit-packed",
                      .is_in_mm = true,
                      .declared_points = 0,
                      .is_packed = true};
    for (const E57Scan& scan : *scans) {
      header.has_normals |= scan.has_normals();
      any_placed_ |= scan.is_placed;
      header.declared_points = saturating_add(*header.declared_points, scan.points);
    }
    header.has_views = any_placed_ || scans->size() > 1;
    PLUMBLINE_TRY(batch_.begin(header));
    const Status again = pages_.rewind();
    if (!again && again.error().code() == ErrorCode::kUnsupported) {
      return input_.fail(ErrorCode::kUnsupported,
                         "an E57 is read twice, and this one comes through a pipe;\tgive it as a file");
    }
    PLUMBLINE_TRY(again);
    input_.report_within(kFirstPass, 1);
    const auto kept =
        memory_.take_bottom<char>(memory_.available() / Arena::kAlignment * Arena::kAlignment, "reading E57");
    PLUMBLINE_TRY(kept);
    // No section is read twice, whatever the XML says.
    std::sort(scans->begin(), scans->end(), [](const E57Scan& a, const E57Scan& b) { return a.section < b.section; });
    for (const E57Scan& scan : *scans) {
      // Programs give merged clouds a pose that does nothing, too. Beside other poses it is the first scanner's.
      ScanView view;
      if (any_placed_) view.scanner = scan.pose.translation * kMmPerMetre;
      if (header.has_views) PLUMBLINE_TRY(batch_.begin_view(view));
      PLUMBLINE_TRY(read_scan(scan, *kept));
    }
    return {};
  }

 private:
  static unsigned long long shown(std::uint64_t number) { return static_cast<unsigned long long>(number); }

  tl::unexpected<Error> damaged(const char* what) const {
    return input_.fail(ErrorCode::kMalformed, "byte %llu: %s; the file is damaged.\tExport it again",
                       shown(pages_.file_offset()), what);
  }

  Status read_header() {
    std::array<char, 48> head;
    const auto ready = input_.fill(head.size());
    PLUMBLINE_TRY(ready);
    // The size of a page is needed before its checksum can be.
    if (*ready >= head.size()) {
      const auto page = load<std::uint64_t>({input_.begin(), head.size()}, 40);
      if (page != E57Pages::kPage) {
        return input_.fail(ErrorCode::kUnsupported,
                           "byte 40: pages of %llu bytes instead of %zu;\texport the file again", shown(page),
                           E57Pages::kPage);
      }
    }
    PLUMBLINE_TRY(pages_.read(head));
    const auto major = load<std::uint32_t>(head, 8);
    if (major != 1) {
      return input_.fail(ErrorCode::kUnsupported, "byte 8: version %u of E57 is not supported;\texport it as version 1",
                         major);
    }
    const auto xml_at = load<std::uint64_t>(head, 24);
    const auto logical = E57Pages::logical(xml_at);
    xml_bytes_ = load<std::uint64_t>(head, 32);
    if (!logical || *logical < head.size() || xml_bytes_ == 0) {
      return input_.fail(ErrorCode::kMalformed,
                         "byte 24: an XML section of %llu bytes at byte %llu; the file is damaged.\tExport it again",
                         shown(xml_bytes_), shown(xml_at));
    }
    if (xml_bytes_ > kMostXmlBytes) {
      return input_.fail(ErrorCode::kUnsupported,
                         "byte 32: an XML section of %llu bytes; at most %llu are read.\tExport only the points",
                         shown(xml_bytes_), shown(kMostXmlBytes));
    }
    xml_at_ = *logical;
    return {};
  }

  /// A section has a header of 32 bytes and then packets.
  Status read_scan(const E57Scan& scan, std::span<char> kept) {
    const auto start = E57Pages::logical(scan.section);
    if (!start || *start < pages_.offset()) {
      return input_.fail(ErrorCode::kMalformed,
                         "the points of a scan are at byte %llu, within others; the file is damaged.\tExport it again",
                         shown(scan.section));
    }
    PLUMBLINE_TRY(pages_.seek(*start));
    std::array<char, 32> head;
    PLUMBLINE_TRY(pages_.read(head));
    const auto data = E57Pages::logical(load<std::uint64_t>(head, 16));
    const std::uint64_t end = saturating_add(*start, load<std::uint64_t>(head, 8));
    if (head[0] != 1 || !data || *data < pages_.offset() || *data > end) return damaged("expected a section of points");
    PLUMBLINE_TRY(pages_.seek(*data));
    find_slots(scan);
    E57Streams streams(scan, kept);
    done_ = 0;
    while (done_ < scan.points) {
      if (pages_.offset() >= end) {
        return input_.fail(
            ErrorCode::kTruncated,
            "byte %llu: the section ends with %llu of the %llu points that the XML declares;\texport the "
            "file again",
            shown(pages_.file_offset()), shown(done_), shown(scan.points));
      }
      PLUMBLINE_TRY(read_packet(scan, streams));
    }
    return {};
  }

  void find_slots(const E57Scan& scan) {
    slot_of_stream_.fill(kE57Slots);
    for (std::size_t slot = 0; slot < kE57Slots; ++slot) {
      const E57Field& field = scan.field[slot];
      if (field.kind != E57Field::Kind::kNone) slot_of_stream_[field.stream] = static_cast<std::uint8_t>(slot);
    }
  }

  Status read_packet(const E57Scan& scan, E57Streams& streams) {
    constexpr char kIndex = 0;
    constexpr char kData = 1;
    constexpr char kEmpty = 2;
    const std::uint64_t start = pages_.offset();
    std::array<char, 6> head;
    PLUMBLINE_TRY(pages_.read(std::span(head).first(4)));
    const std::uint64_t end = start + load<std::uint16_t>(head, 2) + 1;
    if (head[0] == kIndex || head[0] == kEmpty) {
      return pages_.seek(std::max(end, pages_.offset()));
    }
    if (head[0] != kData) return damaged("expected a packet of points");
    PLUMBLINE_TRY(pages_.read(std::span(head).last(2)));
    if (load<std::uint16_t>(head, 4) != scan.streams)
      return damaged("a packet with other fields than the XML declares");
    const auto lengths = std::span(lengths_).first(2 * scan.streams);
    PLUMBLINE_TRY(pages_.read(lengths));
    std::uint64_t sum = pages_.offset();
    for (std::size_t s = 0; s < scan.streams; ++s) sum += load<std::uint16_t>(lengths, 2 * s);
    if (sum > end) return damaged("a packet shorter than its parts");
    streams.begin_packet();
    for (std::size_t s = 0; s < scan.streams; ++s) {
      const std::size_t bytes = load<std::uint16_t>(lengths, 2 * s);
      if (slot_of_stream_[s] == kE57Slots) {
        PLUMBLINE_TRY(pages_.seek(pages_.offset() + bytes));
        continue;
      }
      const auto to = streams.begin_stream(slot_of_stream_[s], bytes);
      if (!to) {
        return input_.fail(ErrorCode::kUnsupported,
                           "byte %llu: one coordinate comes too long before the others;\texport the file again",
                           shown(pages_.file_offset()));
      }
      PLUMBLINE_TRY(pages_.read(*to));
    }
    PLUMBLINE_TRY(pages_.seek(end));
    return deliver(scan, streams);
  }

  Status deliver(const E57Scan& scan, E57Streams& streams) {
    std::array<double, kE57Slots> values;
    SlotValues row = {};
    const std::uint64_t count = std::min(streams.ready(), scan.points - done_);
    for (std::uint64_t i = 0; i < count; ++i) {
      streams.take(values);
      if (values[kE57Invalid] != 0) {
        batch_.leave_out();
        continue;
      }
      if (scan.is_spherical) to_cartesian(values);
      std::copy_n(values.begin(), kSlots, row);
      scan.pose.apply(row);
      for (const std::size_t slot : {kX, kY, kZ}) row[slot] *= kMmPerMetre;
      batch_.add(row);
      if (batch_.full()) PLUMBLINE_TRY(batch_.flush());
    }
    done_ += count;
    return {};
  }

  ByteInput& input_;
  E57Pages pages_;
  PointBatch& batch_;
  Arena& memory_;
  std::uint64_t xml_at_ = 0;  ///< logical
  std::uint64_t xml_bytes_ = 0;
  std::uint64_t done_ = 0;   ///< points of the scan
  bool any_placed_ = false;  ///< E57Scan::is_placed
  std::array<std::uint8_t, kE57MostStreams> slot_of_stream_ = {};
  std::array<char, 2 * kE57MostStreams> lengths_ = {};
};

}  // namespace

Status read_e57(ByteInput& input, PointBatch& batch, Arena& memory) { return E57Reader(input, batch, memory).read(); }

}  // namespace plumbline::inline slicer
