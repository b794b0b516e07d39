#pragma once
/// Meshes of known objects, and the files that hold them.

#include <algorithm>
#include <array>
#include <cstdint>
#include <cstdio>
#include <map>
#include <random>
#include <string>
#include <utility>
#include <vector>

#include "slicer/core/numbers/vec.hpp"
#include "tests/slicer/reader/scan_fixture.hpp"
#include "tests/slicer/support/surface_files.hpp"
#include "tests/slicer/support/threemf_file.hpp"

namespace plumbline::testing {

struct TestMesh {
  std::vector<Vec3d> vertices;
  std::vector<std::array<std::uint32_t, 3>> faces;  ///< counter-clockwise from outside
};

/// An axis-aligned box of 12 triangles: the first two are its underside, the last two its top.
inline TestMesh box_mesh(const Vec3d& low, const Vec3d& high) {
  TestMesh mesh;
  for (std::uint32_t i = 0; i < 8; ++i) {
    mesh.vertices.push_back(
        {(i & 1U) != 0 ? high[0] : low[0], (i & 2U) != 0 ? high[1] : low[1], (i & 4U) != 0 ? high[2] : low[2]});
  }
  mesh.faces = {{0, 2, 3}, {0, 3, 1}, {0, 1, 5}, {0, 5, 4}, {1, 3, 7}, {1, 7, 5},
                {3, 2, 6}, {3, 6, 7}, {2, 0, 4}, {2, 4, 6}, {4, 5, 7}, {4, 7, 6}};
  return mesh;
}

inline TestMesh tetrahedron_mesh(const Vec3d& a, const Vec3d& b, const Vec3d& c, const Vec3d& d) {
  const bool outwards = (b - a).cross(c - a).dot(d - a) > 0;
  TestMesh mesh{{a, outwards ? c : b, outwards ? b : c, d}, {}};
  mesh.faces = {{0, 1, 2}, {0, 3, 1}, {1, 3, 2}, {2, 3, 0}};
  return mesh;
}

/// An octahedron whose faces are divided `times` times, on a sphere. 8 * 4^times triangles.
inline TestMesh ball_mesh(const Vec3d& centre, double radius, int times) {
  TestMesh mesh{{{1, 0, 0}, {-1, 0, 0}, {0, 1, 0}, {0, -1, 0}, {0, 0, 1}, {0, 0, -1}}, {}};
  mesh.faces = {{0, 2, 4}, {2, 1, 4}, {1, 3, 4}, {3, 0, 4}, {2, 0, 5}, {1, 2, 5}, {3, 1, 5}, {0, 3, 5}};
  for (int i = 0; i < times; ++i) {
    std::map<std::pair<std::uint32_t, std::uint32_t>, std::uint32_t> middles;
    const auto middle = [&](std::uint32_t a, std::uint32_t b) {
      const auto [at, fresh] = middles.try_emplace(std::minmax(a, b), static_cast<std::uint32_t>(mesh.vertices.size()));
      if (fresh) mesh.vertices.push_back((mesh.vertices[a] + mesh.vertices[b]).normalized());
      return at->second;
    };
    std::vector<std::array<std::uint32_t, 3>> faces;
    for (const auto& [a, b, c] : mesh.faces) {
      const std::uint32_t x = middle(a, b);
      const std::uint32_t y = middle(b, c);
      const std::uint32_t z = middle(c, a);
      faces.insert(faces.end(), {{a, x, z}, {x, b, y}, {z, y, c}, {x, y, z}});
    }
    mesh.faces = faces;
  }
  for (Vec3d& v : mesh.vertices) v = centre + radius * v;
  return mesh;
}

inline void append(TestMesh& mesh, const TestMesh& other) {
  const auto first = static_cast<std::uint32_t>(mesh.vertices.size());
  mesh.vertices.insert(mesh.vertices.end(), other.vertices.begin(), other.vertices.end());
  for (const auto& f : other.faces) mesh.faces.push_back({f[0] + first, f[1] + first, f[2] + first});
}

/// Turns the faces in a range over.
inline void flip(TestMesh& mesh, std::size_t first, std::size_t end) {
  for (std::size_t i = first; i < end; ++i) std::swap(mesh.faces[i][1], mesh.faces[i][2]);
}

/// Another order of the faces, and of the corners of each.
inline TestMesh shuffled(TestMesh mesh, std::uint32_t seed) {
  std::mt19937 random(seed);
  for (std::size_t i = mesh.faces.size(); i > 1; --i) std::swap(mesh.faces[i - 1], mesh.faces[random() % i]);
  for (auto& f : mesh.faces) std::rotate(f.begin(), f.begin() + random() % 3, f.end());
  return mesh;
}

inline std::string binary_stl(const TestMesh& mesh) {
  std::string bytes(80, '\0');
  bytes += little(static_cast<std::uint32_t>(mesh.faces.size()));
  for (const auto& f : mesh.faces) {
    bytes += little(0.0F, 0.0F, 0.0F);
    for (const std::uint32_t i : f) {
      const Vec3f v = mesh.vertices[i].cast<float>();
      bytes += little(v[0], v[1], v[2]);
    }
    bytes += little(std::uint16_t{0});
  }
  return bytes;
}

namespace detail {

/// With all digits of a float, so that every format holds the same numbers.
inline std::string numbers(const char* before, const Vec3d& v) {
  const Vec3f f = v.cast<float>();
  char row[128];
  std::snprintf(row, sizeof row, "%s%.9g %.9g %.9g\n", before, static_cast<double>(f[0]), static_cast<double>(f[1]),
                static_cast<double>(f[2]));
  return row;
}
inline std::string face(const char* before, const std::array<std::uint32_t, 3>& f, std::uint32_t first) {
  char row[128];
  std::snprintf(row, sizeof row, "%s%u %u %u\n", before, f[0] + first, f[1] + first, f[2] + first);
  return row;
}

}  // namespace detail

inline std::string ascii_stl(const TestMesh& mesh) {
  std::string text = "solid test\n";
  for (const auto& f : mesh.faces) {
    text += "  facet normal 0 0 0\n    outer loop\n";
    for (const std::uint32_t i : f) text += detail::numbers("      vertex ", mesh.vertices[i]);
    text += "    endloop\n  endfacet\n";
  }
  return text + "endsolid test\n";
}
inline std::string obj_of(const TestMesh& mesh) {
  std::string text = "# test\n";
  for (const Vec3d& v : mesh.vertices) text += detail::numbers("v ", v);
  for (const auto& f : mesh.faces) text += detail::face("f ", f, 1);
  return text;
}
inline std::string off_of(const TestMesh& mesh) {
  std::string text = "OFF\n" + std::to_string(mesh.vertices.size()) + " " + std::to_string(mesh.faces.size()) + " 0\n";
  for (const Vec3d& v : mesh.vertices) text += detail::numbers("", v);
  for (const auto& f : mesh.faces) text += detail::face("3 ", f, 0);
  return text;
}
inline std::string ply_head(const TestMesh& mesh, const char* format) {
  return std::string("ply\nformat ") + format + " 1.0\nelement vertex " + std::to_string(mesh.vertices.size()) +
         "\nproperty float x\nproperty float y\nproperty float z\nelement face " + std::to_string(mesh.faces.size()) +
         "\nproperty list uchar int vertex_indices\nend_header\n";
}
inline std::string ascii_ply(const TestMesh& mesh) {
  std::string text = ply_head(mesh, "ascii");
  for (const Vec3d& v : mesh.vertices) text += detail::numbers("", v);
  for (const auto& f : mesh.faces) text += detail::face("3 ", f, 0);
  return text;
}
template <std::endian Order>
std::string binary_ply_of(const TestMesh& mesh) {
  std::string bytes = ply_head(mesh, Order == std::endian::little ? "binary_little_endian" : "binary_big_endian");
  for (const Vec3d& v : mesh.vertices) {
    const Vec3f f = v.cast<float>();
    bytes += bytes_of<Order>(f[0], f[1], f[2]);
  }
  for (const auto& f : mesh.faces) bytes += bytes_of<Order>(std::uint8_t{3}, f[0], f[1], f[2]);
  return bytes;
}

/// An object of a 3MF model.
inline std::string object_of(const TestMesh& mesh, int id, const std::string& attributes = "") {
  std::string text = "<object id=\"" + std::to_string(id) + "\" " + attributes + "><mesh><vertices>\n";
  for (const Vec3d& v : mesh.vertices) {
    const Vec3f f = v.cast<float>();
    char row[128];
    std::snprintf(row, sizeof row, "<vertex x=\"%.9g\" y=\"%.9g\" z=\"%.9g\"/>\n", static_cast<double>(f[0]),
                  static_cast<double>(f[1]), static_cast<double>(f[2]));
    text += row;
  }
  text += "</vertices><triangles>\n";
  for (const auto& f : mesh.faces) {
    char row[128];
    std::snprintf(row, sizeof row, "<triangle v1=\"%u\" v2=\"%u\" v3=\"%u\"/>\n", f[0], f[1], f[2]);
    text += row;
  }
  return text + "</triangles></mesh></object>\n";
}
inline std::string threemf_of(const TestMesh& mesh) {
  return threemf_with(
      model_of("<resources>" + object_of(mesh, 1) + "</resources><build><item objectid=\"1\"/></build>"));
}

/// The mesh in every format.
inline std::vector<SurfaceFile> files_of(const TestMesh& mesh) {
  return {{"binary.stl", binary_stl(mesh)},
          {"ascii.stl", ascii_stl(mesh)},
          {"mesh.obj", obj_of(mesh)},
          {"mesh.off", off_of(mesh)},
          {"ascii.ply", ascii_ply(mesh)},
          {"little.ply", binary_ply_of<std::endian::little>(mesh)},
          {"big.ply", binary_ply_of<std::endian::big>(mesh)},
          {"mesh.3mf", threemf_of(mesh)}};
}

}  // namespace plumbline::testing
