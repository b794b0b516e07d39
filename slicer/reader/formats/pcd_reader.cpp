#include "slicer/reader/formats/pcd/pcd_compressed.hpp"
#include "slicer/reader/formats/pcd/pcd_header.hpp"
#include "slicer/reader/formats/scan_formats.hpp"
#include "slicer/reader/records/record_binary.hpp"
#include "slicer/reader/records/record_text.hpp"
#include "slicer/reader/records/records_end.hpp"
#include "slicer/reader/stream/line_input.hpp"

namespace plumbline::inline slicer {
namespace {

constexpr const char* encoding_of(PcdData data) {
  switch (data) {
    case PcdData::kAscii: return "ascii";
    case PcdData::kBinary: return "binary little endian";
    case PcdData::kBinaryCompressed: return "binary compressed";
  }
  return "";
}

}  // namespace

Status read_pcd(ByteInput& input, PointBatch& batch, Arena& memory, Arena& columns) {
  LineInput lines(input);
  const auto header = read_pcd_header(lines, memory);
  PLUMBLINE_TRY(header);
  PLUMBLINE_TRY(batch.begin({.format = ScanFormat::kPcd,
                             .encoding = encoding_of(header->data),
                             .has_normals = header->layout.has_normal(),
                             .has_views = header->scanner.has_value(),
                             .declared_points = header->points,
                             .is_packed = header->data == PcdData::kBinaryCompressed,
                             .reader_bytes = compressed_columns_bytes(*header)}));
  if (header->scanner) PLUMBLINE_TRY(batch.begin_view({.scanner = header->scanner}));
  switch (header->data) {
    case PcdData::kAscii:
      PLUMBLINE_TRY(read_text_points(lines, header->layout, header->points, batch));
      return check_text_end(lines, "points", header->points);
    case PcdData::kBinary:
      PLUMBLINE_TRY(read_binary_points(input, header->layout, header->points, std::endian::little, batch));
      return check_end(input, "points", header->points, header->layout.bytes());
    case PcdData::kBinaryCompressed: return read_pcd_compressed(input, *header, batch, columns);
  }
  return {};
}

}  // namespace plumbline::inline slicer
