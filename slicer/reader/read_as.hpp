#pragma once
/// Whether a file that has points and faces is read as a scan or as a mesh.

#include <cstdint>

namespace plumbline::inline slicer {

enum class ReadAs : std::uint8_t {
  kAuto,    ///< STL and OFF are meshes; PLY and OBJ if their faces are the surface of an object
  kPoints,  ///< faces are ignored
  kMesh,    ///< points without faces are ignored
};

/// "auto", "points", "mesh".
inline const char* to_string(ReadAs as) {
  return as == ReadAs::kPoints ? "points" : as == ReadAs::kMesh ? "mesh" : "auto";
}

}  // namespace plumbline::inline slicer
