#include "slicer/reader/formats/ply_header.hpp"
#include "slicer/reader/formats/scan_formats.hpp"
#include "slicer/reader/records/record_binary.hpp"
#include "slicer/reader/records/record_text.hpp"
#include "slicer/reader/stream/line_input.hpp"

namespace plumbline {

Status read_ply(ByteInput& input, PointBatch& batch, Arena& memory) {
  LineInput lines(input);
  const auto header = read_ply_header(lines, memory);
  PLUMBLINE_TRY(header);
  const PlyElement& vertex = header->vertex;
  PLUMBLINE_TRY(batch.begin({.format = ScanFormat::kPly,
                             .encoding = header->encoding(),
                             .has_normals = vertex.layout.has_normal(),
                             .declared_points = vertex.count}));
  for (const PlyElement& element : header->before_vertex) {
    if (element.layout.steps().empty()) continue;  // no properties: no bytes, no line
    PLUMBLINE_TRY(header->ascii ? skip_text_records(lines, element.count)
                                : skip_binary_records(input, element.layout, element.count, header->order));
  }
  return header->ascii ? read_text_points(lines, vertex.layout, vertex.count, batch)
                       : read_binary_points(input, vertex.layout, vertex.count, header->order, batch);
}

}  // namespace plumbline
