#include "slicer/reader/scan_reader.hpp"

#include "slicer/reader/formats/format_probe.hpp"
#include "slicer/reader/formats/scan_formats.hpp"
#include "slicer/reader/stream/point_batch.hpp"

namespace plumbline::inline slicer {
namespace {

/// Bytes: the longest row of a text file, and the longest line of a header. Rows of scans are far shorter, so a larger
/// window would only cost memory.
constexpr std::size_t kWindow = std::size_t{64} * 1024;

Status read_as(ScanFormat format, ByteInput& input, PointBatch& batch, Arena& memory, Arena* lent) {
  switch (format) {
    case ScanFormat::kPly: return read_ply(input, batch, memory);
    case ScanFormat::kXyz: return read_xyz(input, batch, memory);
    case ScanFormat::kPcd: return read_pcd(input, batch, memory, lent != nullptr ? *lent : memory);
    case ScanFormat::kObj: return read_obj(input, batch, memory);
    case ScanFormat::kLas: return read_las(input, batch);
    case ScanFormat::kPtx: return read_ptx(input, batch);
    case ScanFormat::kSpz: return read_spz(input, batch, memory, lent != nullptr ? *lent : memory);
    case ScanFormat::kE57: return read_e57(input, batch, memory);
    case ScanFormat::kStl:
    case ScanFormat::kOff:
    case ScanFormat::k3mf:
      return telling(
          Told(ToldCode::kNotPoints),
          input.fail(ErrorCode::kUnsupported,
                     "this is %s, a mesh without scanned points;\tread it as a mesh, and give no scans together with "
                     "it",
                     format == ScanFormat::kStl   ? "STL"
                     : format == ScanFormat::kOff ? "OFF"
                                                  : "3MF"));
  }
  return {};
}

}  // namespace

Expected<ScanSummary> read_scan(ByteSource& source, PointSink& sink, std::span<std::byte> workspace, Arena* lent) {
  Arena memory(workspace);
  const auto window = memory.take_bottom<std::byte>(kWindow, "reading the scan");
  PLUMBLINE_TRY(window);
  const auto room = memory.take_bottom<ScanPoint>(PointBatch::kPoints, "reading the scan");
  PLUMBLINE_TRY(room);

  ByteInput input(source, sink, *window);
  const auto format = probe_format(input);
  PLUMBLINE_TRY(format);
  ScanSummary summary;
  PointBatch batch(sink, *room, summary);
  PLUMBLINE_TRY(read_as(*format, input, batch, memory, lent));
  PLUMBLINE_TRY(batch.flush());
  PLUMBLINE_TRY(input.finish());
  summary.bytes = input.farthest();
  if (summary.points == 0 && summary.left_out > 0) {
    return input.fail(ErrorCode::kNoPoints,
                      "no usable point (marked as invalid: %llu; with a coordinate that is not finite: %llu);\texport "
                      "the scan again",
                      static_cast<unsigned long long>(summary.left_out),
                      static_cast<unsigned long long>(summary.not_finite));
  }
  if (summary.points == 0 && summary.not_finite == 0) {
    return input.fail(ErrorCode::kNoPoints, "the file has no points;\texport the scan again, with its points");
  }
  if (summary.points == 0) {
    return input.fail(ErrorCode::kNoPoints,
                      "no usable point: each has a coordinate that is not finite (%llu in all);\texport the scan "
                      "again",
                      static_cast<unsigned long long>(summary.not_finite));
  }
  return summary;
}

}  // namespace plumbline::inline slicer
