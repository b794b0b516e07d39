#pragma once
/// A surface as a file of each format.

#include <array>
#include <cstdio>
#include <string>
#include <vector>

#include "tests/slicer/reader/scan_fixture.hpp"
#include "tests/slicer/support/scan_cloud.hpp"

namespace plumbline::testing {

struct SurfaceFile {
  const char* name;
  std::string bytes;
};

/// Binary PLY, XYZ, OBJ, and compressed PCD.
inline std::vector<SurfaceFile> files_of(const Surface& surface) {
  std::string xyz;
  std::string obj;
  std::array<std::string, 6> columns;
  for (const SurfacePoint& p : surface) {
    const Vec3d& v = p.position;
    const Vec3d& n = p.normal;
    char row[160];
    std::snprintf(row, sizeof row, "%g %g %g %g %g %g\n", v[0], v[1], v[2], n[0], n[1], n[2]);
    xyz += row;
    std::snprintf(row, sizeof row, "vn %g %g %g\nv %g %g %g\n", n[0], n[1], n[2], v[0], v[1], v[2]);
    obj += row;
    for (std::size_t axis = 0; axis < 3; ++axis) {
      columns[axis] += little(static_cast<float>(v[static_cast<Eigen::Index>(axis)]));
      columns[3 + axis] += little(static_cast<float>(n[static_cast<Eigen::Index>(axis)]));
    }
  }
  std::string all;
  for (const std::string& column : columns) all += column;
  const std::string block = lzf_compress(all);
  const std::string count = std::to_string(surface.size());
  const std::string pcd =
      "# .PCD v0.7\nVERSION 0.7\nFIELDS x y z normal_x normal_y normal_z\nSIZE 4 4 4 4 4 4\nTYPE F F F F F F\n"
      "COUNT 1 1 1 1 1 1\nWIDTH " +
      count + "\nHEIGHT 1\nPOINTS " + count + "\nDATA binary_compressed\n" +
      little(static_cast<std::uint32_t>(block.size()), static_cast<std::uint32_t>(all.size())) + block;
  return {{"scan.ply", binary_ply(surface)}, {"scan.xyz", xyz}, {"scan.obj", obj}, {"scan.pcd", pcd}};
}

}  // namespace plumbline::testing
