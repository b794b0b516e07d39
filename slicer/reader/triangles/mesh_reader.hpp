#pragma once
/// Reads any supported format of meshes as a stream of triangles.

#include <cstddef>
#include <span>

#include "slicer/core/byte_source.hpp"
#include "slicer/reader/triangles/threemf/model_copy.hpp"
#include "slicer/reader/triangles/triangle.hpp"
#include "slicer/reader/triangles/vertex_list.hpp"

namespace plumbline::inline slicer {

/// Whether a file holds a mesh, as far as its beginning shows.
enum class MeshHint : std::uint8_t {
  kNone,        ///< it has no faces, or is no format that is known
  kMaybe,       ///< it has vertices, and perhaps faces between them: PLY and OBJ
  kPackedMesh,  ///< as kMesh, but its size does not tell how many vertices there may be: 3MF
  kMesh,        ///< it has vertices and faces: OFF
  kTriangles,   ///< it has nothing but triangles: STL. No vertices need to be kept
};

/// @param source     at its beginning; some of it is read
/// @param workspace  kReaderWorkspace bytes
/// @retval ErrorCode::kCannotRead  the source failed. What is wrong with the file is no error here
[[nodiscard]] Expected<MeshHint> hint_of(ByteSource& source, std::span<std::byte> workspace);

/// Reads a mesh from start to end and passes its triangles to `sink`.
/// @param vertices   cleared first; keeps those of an indexed format
/// @param workspace  at least kReaderWorkspace bytes, uninitialised
/// @returns what was read, even if it is no triangle
/// @retval ErrorCode::kUnknownFormat, kMalformed, kTruncated, kUnsupported, kOutOfMemory  the message gives source.name(), byte,
///         line or face, what was expected and what was found
/// @retval any error of the source or the sink
[[nodiscard]] Expected<MeshSummary> read_mesh(ByteSource& source, TriangleSink& sink, VertexList& vertices,
                                              std::span<std::byte> workspace);
/// The same, and copies a 3MF for later readings.
/// @param copy  may be in the room of the vertices; is_finished() if it was a 3MF for which there is room
[[nodiscard]] Expected<MeshSummary> read_mesh(ByteSource& source, TriangleSink& sink, VertexList& vertices,
                                              std::span<std::byte> workspace, ModelCopy& copy);
/// The same from a copy that is finished.
[[nodiscard]] Expected<MeshSummary> read_mesh(const ModelCopy& copy, TriangleSink& sink,
                                              std::span<std::byte> workspace);

}  // namespace plumbline::inline slicer
