#pragma once
/// One reader for each format of meshes. Each starts at the first byte of the file, or after its byte order mark, and adds every
/// triangle. The caller flushes the last batch.

#include "slicer/core/arena.hpp"
#include "slicer/reader/stream/byte_input.hpp"
#include "slicer/reader/triangles/threemf/model_copy.hpp"
#include "slicer/reader/triangles/triangle_batch.hpp"
#include "slicer/reader/triangles/vertex_list.hpp"

namespace plumbline::inline slicer {

/// Where an indexed format keeps its vertices, and where a reader keeps what it needs besides the window.
struct MeshRoom {
  VertexList& vertices;
  Arena& memory;
};

/// Stereolithography: ascii and binary, with any number of solids. A binary file whose number of triangles is 0 or 2^32 - 1, as
/// programs write that don't know it in advance, is read to its end.
[[nodiscard]] Status read_stl(ByteInput& input, TriangleBatch& batch);

/// Polygon file format: faces as lists of vertex indices, ascii and binary in both byte orders.
[[nodiscard]] Status read_ply_mesh(ByteInput& input, TriangleBatch& batch, const MeshRoom& room);

/// Wavefront OBJ: faces with any number of corners, positive and negative indices.
[[nodiscard]] Status read_obj_mesh(ByteInput& input, TriangleBatch& batch, const MeshRoom& room);

/// Object file format of Geomview, ascii: OFF, COFF, NOFF, STOFF and their combinations.
[[nodiscard]] Status read_off(ByteInput& input, TriangleBatch& batch, const MeshRoom& room);

/// 3D Manufacturing Format: the objects that the build places, in mm. Supports and modifiers are left out. Reads the input twice, since the
/// build comes after the meshes, unless `copy` has room for these.
/// @param copy  is_finished() then; may be in the room of the vertices
/// @retval ErrorCode::kUnsupported  encrypted, packed other than by deflate, or it needs an extension that changes its shape
[[nodiscard]] Status read_3mf(ByteInput& input, TriangleBatch& batch, const MeshRoom& room, ModelCopy& copy);
/// The same from the copy.
[[nodiscard]] Status read_3mf_copy(const ModelCopy& copy, TriangleBatch& batch, Arena& memory);

/// Adds the vertices of an object to the counts, and clears them.
void count_vertices(VertexList& vertices, MeshSummary& summary);

/// The error of a mesh that has more vertices than there is room for.
tl::unexpected<Error> fail_vertices(const ByteInput& input, const VertexList& vertices);

}  // namespace plumbline::inline slicer
