// Reads any bytes as a mesh, slices it, and checks what must always hold.
//
// The first byte: bits 0 and 1 the file's ending (STL, OBJ, PLY, OFF), bit 2 auto instead of mesh, bits 3 and 4 the base choice, bit 5
// 3MF instead, bit 6 turned. With bits 5 and 7 the rest is the model inside of the 3MF archive, since hardly any change of a byte would
// leave the archive's checksum right.

#include <algorithm>
#include <array>
#include <cstdint>
#include <cstring>
#include <string>
#include <string_view>
#include <vector>

#include "slicer/reader/triangles/mesh_reader.hpp"
#include "slicer/slicer.hpp"
#include "tests/fuzz/fuzz_scan.hpp"
#include "tests/slicer/support/threemf_file.hpp"

namespace plumbline::firmware::fuzz {
namespace {

class CheckingTriangles final : public TriangleSink {
 public:
  Status take(std::span<const Triangle> triangles) override {
    require(!triangles.empty(), "an empty batch");
    for (const Triangle& t : triangles) {
      for (const Vec3d& p : t) {
        require(p.allFinite() && p.cwiseAbs().maxCoeff() <= kLargestCoordinate, "a corner is not usable");
        for (int axis = 0; axis < 3; ++axis) {
          std::uint64_t bits = 0;
          std::memcpy(&bits, &p[axis], sizeof bits);
          hash = (hash ^ bits) * 1099511628211U;
        }
      }
    }
    count += triangles.size();
    return {};
  }
  bool progress(double fraction) override {
    require(fraction >= 0 && fraction <= 1, "a fraction is outside of 0 to 1");
    return true;
  }
  std::uint64_t count = 0;
  std::uint64_t hash = 14695981039346656037U;
};

/// @returns a number for the whole outcome
std::uint64_t read_it(std::string_view bytes, const char* name, bool whole) {
  Pieces source(bytes, name, whole);
  std::vector<std::byte> memory(std::size_t{1} << 18U, std::byte{0xA5});
  Arena arena(memory);
  VertexList vertices = *VertexList::create(10'000, arena);
  static std::vector<std::byte> workspace(kReaderWorkspace);
  std::fill(workspace.begin(), workspace.end(), std::byte{0x5A});
  CheckingTriangles sink;
  const auto summary = read_mesh(source, sink, vertices, workspace);
  if (!summary) {
    require(std::strlen(summary.error().message()) > 10, "an error without a message");
    return static_cast<std::uint64_t>(summary.error().code());
  }
  require(summary->triangles == sink.count, "another number of triangles is reported");
  require(summary->used_vertices <= summary->vertices, "more vertices are used than there are");
  return sink.hash ^ summary->not_finite ^ summary->faces;
}

void check_crossings(const RRep& rrep) {
  const PrintGrid& grid = rrep.grid;
  require(rrep.first.size() == std::size_t{grid.layers} + 1, "an entry for each layer and the end");
  require(rrep.first.front() == 0 && rrep.first.back() == rrep.packed.size(), "the layers hold all crossings");
  const CrossingPacking packing(grid);
  for (std::uint32_t k = 0; k < grid.layers; ++k) {
    require(rrep.first[k] <= rrep.first[k + 1], "layers in order");
    for (std::uint32_t i = rrep.first[k]; i < rrep.first[k + 1]; ++i) {
      require(packing.pixel(rrep.packed[i]) < grid.columns * grid.rows, "a crossing outside of the grid");
      require(i == rrep.first[k] || packing.pixel(rrep.packed[i - 1]) < packing.pixel(rrep.packed[i]),
              "a pixel twice in a layer, or out of order");
    }
  }
}

std::uint64_t slice_it(std::string_view bytes, const char* name, std::uint8_t options, std::byte content) {
  Pieces source(bytes, name, true);
  static std::vector<std::byte> memory;
  memory.assign(std::size_t{6} << 20U, content);
  Arena arena(memory);
  SliceSettings settings;
  settings.as = (options & 4U) != 0 ? ReadAs::kAuto : ReadAs::kMesh;
  settings.base = static_cast<BaseChoice>(std::min((options >> 3U) & 3U, 2U));
  settings.placement.size = PrintSize{Side::kLength, 1.5};  // winding numbers of broken meshes take long here
  settings.placement.pixel_pitch_mm = settings.placement.layer_height_mm = 0.1F;
  settings.placement.rotation_degrees = {options & 64U ? 30.0 : 0.0, 0, 0};
  SliceReport report;
  const auto rrep = slice(source, settings, arena, nullptr, report);
  require(arena.top_used() == 0, "scratch is left in the arena");
  if (!rrep) {
    require(arena.used() == 0, "an error leaves something in the arena");
    require(std::strlen(rrep.error().message()) > 10, "an error without a message");
    return static_cast<std::uint64_t>(rrep.error().code());
  }
  check_crossings(*rrep);
  std::uint64_t hash = rrep->grid.layers;
  for (const std::uint32_t packed : rrep->packed) hash = (hash ^ packed) * 1099511628211U;
  if (report.mesh && report.mesh->closed) {
    require(report.mesh->broken_rays == 0, "a ray leaves a closed mesh more often than it enters");
  }
  return hash;
}

}  // namespace
}  // namespace plumbline::firmware::fuzz

extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
  using namespace plumbline::firmware::fuzz;
  constexpr std::array kNames = {"a.stl", "a.obj", "a.ply", "a.off"};
  if (size == 0) return 0;
  std::string bytes(reinterpret_cast<const char*>(data) + 1, size - 1);
  const char* const name = (data[0] & 32U) != 0 ? "a.3mf" : kNames[data[0] & 3U];
  if ((data[0] & 160U) == 160U) bytes = plumbline::testing::threemf_with(bytes);
  require(read_it(bytes, name, true) == read_it(bytes, name, false), "reading in pieces gives another mesh");
  const std::uint64_t first = slice_it(bytes, name, data[0], std::byte{0xA5});
  require(slice_it(bytes, name, data[0], std::byte{0x5A}) == first, "the second run differs");
  return 0;
}
