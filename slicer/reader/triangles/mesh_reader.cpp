#include "slicer/reader/triangles/mesh_reader.hpp"

#include <algorithm>

#include "slicer/reader/formats/format_probe.hpp"
#include "slicer/reader/formats/ply_header.hpp"
#include "slicer/reader/triangles/triangle_formats.hpp"

namespace plumbline::inline slicer {
namespace {

constexpr std::size_t kWindow = std::size_t{64} * 1024;  ///< bytes: the longest line, as in read_scan()

/// A PLY file with fewer faces a vertex is a scan with something beside it. A closed mesh has one face a vertex or two; large
/// polygons make them fewer, and triangles that share no vertex have a third.
constexpr std::uint64_t kMostVerticesPerFace = 4;

Expected<MeshHint> hint_of_ply(ByteInput& input, Arena& memory) {
  LineInput lines(input);
  const auto header = read_ply_header(lines, memory);
  if (!header) {
    if (header.error().code() == ErrorCode::kCannotRead) return tl::unexpected<Error>(header.error());
    return MeshHint::kNone;
  }
  const bool enough = header->strips || header->declared_faces >= header->vertex.count / kMostVerticesPerFace;
  return enough && header->declared_faces > 0 ? MeshHint::kMaybe : MeshHint::kNone;
}

}  // namespace

tl::unexpected<Error> fail_vertices(const ByteInput& input, const VertexList& vertices) {
  return input.fail(ErrorCode::kOutOfMemory,
                    "the mesh has more vertices than the %llu that the arena has room for.\tUse a larger arena, "
                    "save it as binary STL, which needs no room, or reduce its triangles",
                    static_cast<unsigned long long>(vertices.capacity()));
}

void count_vertices(VertexList& vertices, MeshSummary& summary) {
  summary.vertices += vertices.size();
  summary.used_vertices += vertices.used();
  summary.most_vertices = std::max(summary.most_vertices, vertices.size());
  vertices.clear();
}

Expected<MeshHint> hint_of(ByteSource& source, std::span<std::byte> workspace) {
  Arena memory(workspace);
  const auto window = memory.take_bottom<std::byte>(kWindow, "reading the mesh");
  PLUMBLINE_TRY(window);
  NoProgress progress;
  ByteInput input(source, progress, *window);
  const auto format = probe_format(input);
  if (!format) {
    if (format.error().code() == ErrorCode::kCannotRead) return tl::unexpected<Error>(format.error());
    return MeshHint::kNone;
  }
  switch (*format) {
    case ScanFormat::kStl: return MeshHint::kTriangles;
    case ScanFormat::kOff: return MeshHint::kMesh;
    case ScanFormat::k3mf: return MeshHint::kPackedMesh;
    case ScanFormat::kPly: return hint_of_ply(input, memory);
    case ScanFormat::kObj: return MeshHint::kMaybe;
    case ScanFormat::kXyz:
    case ScanFormat::kPcd:
    case ScanFormat::kLas:
    case ScanFormat::kPtx:
    case ScanFormat::kE57:
    case ScanFormat::kSpz: break;
  }
  return MeshHint::kNone;
}

Expected<MeshSummary> read_mesh(ByteSource& source, TriangleSink& sink, VertexList& vertices,
                                std::span<std::byte> workspace) {
  ModelCopy none({});
  return read_mesh(source, sink, vertices, workspace, none);
}

Expected<MeshSummary> read_mesh(const ModelCopy& copy, TriangleSink& sink, std::span<std::byte> workspace) {
  Arena memory(workspace);
  const auto room = memory.take_bottom<Triangle>(TriangleBatch::kTriangles, "reading the mesh");
  PLUMBLINE_TRY(room);
  MeshSummary summary;
  TriangleBatch batch(sink, *room, summary);
  PLUMBLINE_TRY(read_3mf_copy(copy, batch, memory));
  PLUMBLINE_TRY(batch.flush());
  PLUMBLINE_TRY(batch.report(1));
  summary.bytes = copy.file_bytes();
  return summary;
}

Expected<MeshSummary> read_mesh(ByteSource& source, TriangleSink& sink, VertexList& vertices,
                                std::span<std::byte> workspace, ModelCopy& copy) {
  Arena memory(workspace);
  const auto window = memory.take_bottom<std::byte>(kWindow, "reading the mesh");
  PLUMBLINE_TRY(window);
  const auto room = memory.take_bottom<Triangle>(TriangleBatch::kTriangles, "reading the mesh");
  PLUMBLINE_TRY(room);
  ByteInput input(source, sink, *window);
  const auto format = probe_format(input);
  PLUMBLINE_TRY(format);
  vertices.clear();
  MeshSummary summary;
  TriangleBatch batch(sink, *room, summary);
  const MeshRoom mesh{vertices, memory};
  switch (*format) {
    case ScanFormat::kStl: PLUMBLINE_TRY(read_stl(input, batch)); break;
    case ScanFormat::kOff: PLUMBLINE_TRY(read_off(input, batch, mesh)); break;
    case ScanFormat::k3mf: PLUMBLINE_TRY(read_3mf(input, batch, mesh, copy)); break;
    case ScanFormat::kPly: PLUMBLINE_TRY(read_ply_mesh(input, batch, mesh)); break;
    case ScanFormat::kObj: PLUMBLINE_TRY(read_obj_mesh(input, batch, mesh)); break;
    case ScanFormat::kXyz:
    case ScanFormat::kPcd:
    case ScanFormat::kLas:
    case ScanFormat::kPtx:
    case ScanFormat::kE57:
    case ScanFormat::kSpz:
      return telling(Told(ToldCode::kNoFaces),
                     input.fail(ErrorCode::kUnsupported, "the file has points but no faces;\tread it as points"));
  }
  PLUMBLINE_TRY(batch.flush());
  PLUMBLINE_TRY(input.finish());
  count_vertices(vertices, summary);
  summary.bytes = input.farthest();
  return summary;
}

}  // namespace plumbline::inline slicer
