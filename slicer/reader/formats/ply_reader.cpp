#include "slicer/reader/formats/ply_header.hpp"
#include "slicer/reader/formats/scan_formats.hpp"
#include "slicer/reader/formats/splats/splat_filter.hpp"
#include "slicer/reader/records/record_binary.hpp"
#include "slicer/reader/records/record_text.hpp"
#include "slicer/reader/records/records_end.hpp"
#include "slicer/reader/stream/line_input.hpp"

namespace plumbline::inline slicer {
namespace {

/// Elements behind the vertices are not read, but where rows may not fit their header.
Status read_text_vertices(const PlyHeader& header, LineInput& lines, PointBatch& batch) {
  TextRecords records(lines);
  for (const PlyElement& element : header.before_vertex) {
    PLUMBLINE_TRY(records.skip(element.layout, element.count, "records before its points"));
  }
  const PlyElement& vertex = header.vertex;
  PLUMBLINE_TRY(records.read_points(vertex.layout, vertex.count, batch));
  if (header.ends_with_vertices) return records.check_end("vertices", vertex.count);
  if (!records.is_loose()) return {};
  for (const PlyElement& element : header.before_face) {
    PLUMBLINE_TRY(records.skip(element.layout, element.count, "records after its points"));
  }
  PLUMBLINE_TRY(records.skip(header.face.layout, header.face.count, "faces"));
  if (header.face.count > 0 && !header.ends_with_faces) return {};
  return records.check_end("faces", header.face.count);
}

Status read_vertices(const PlyHeader& header, LineInput& lines, PointBatch& batch) {
  if (header.ascii) return read_text_vertices(header, lines, batch);
  ByteInput& input = lines.input();
  for (const PlyElement& element : header.before_vertex) {
    PLUMBLINE_TRY(skip_binary_records(input, element.layout, element.count, header.order));
  }
  const PlyElement& vertex = header.vertex;
  PLUMBLINE_TRY(read_binary_points(input, vertex.layout, vertex.count, header.order, batch));
  return header.ends_with_vertices ? check_end(input, "vertices", vertex.count, vertex.layout.least_bytes()) : Status();
}

const char* splat_encoding(const PlyHeader& header) {
  if (header.ascii) return "ascii splats";
  return header.order == std::endian::little ? "binary little endian splats" : "binary big endian splats";
}

/// @param start  of the file's text in the input
Status read_splats(const PlyHeader& header, LineInput& lines, std::uint64_t start, PointBatch& batch, Arena& memory) {
  ByteInput& input = lines.input();
  SplatFilter filter(header.vertex.layout.has(kThirdScale));
  batch.filter_by(&filter);
  input.report_within(0, 0.5);
  PLUMBLINE_TRY(read_vertices(header, lines, batch));
  filter.end_survey();
  const Status again = input.rewind();
  if (!again && again.error().code() == ErrorCode::kUnsupported) {
    return input.fail(ErrorCode::kUnsupported,
                      "splats are read twice, and these come through a pipe;\tgive them as a file");
  }
  PLUMBLINE_TRY(again);
  input.report_within(0.5, 1);
  PLUMBLINE_TRY(input.skip(start));
  LineInput lines_again(input);
  const auto header_again = read_ply_header(lines_again, memory);
  PLUMBLINE_TRY(header_again);
  return read_vertices(*header_again, lines_again, batch);
}

}  // namespace

Status read_ply(ByteInput& input, PointBatch& batch, Arena& memory) {
  const std::uint64_t start = input.offset();
  LineInput lines(input);
  const auto header = read_ply_header(lines, memory);
  PLUMBLINE_TRY(header);
  const PlyElement& vertex = header->vertex;
  const bool is_splat = vertex.layout.is_splat();
  PLUMBLINE_TRY(batch.begin({.format = ScanFormat::kPly,
                             .encoding = is_splat ? splat_encoding(*header) : header->encoding(),
                             .has_normals = is_splat || vertex.layout.has_normal(),
                             .has_unsigned_normals = is_splat,
                             .declared_points = vertex.count}));
  if (!is_splat) return read_vertices(*header, lines, batch);
  const Status read = read_splats(*header, lines, start, batch, memory);
  batch.filter_by(nullptr);
  return read;
}

}  // namespace plumbline::inline slicer
