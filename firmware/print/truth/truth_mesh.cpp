#include "firmware/print/truth/truth_mesh.hpp"

#include <unistd.h>

#include <algorithm>
#include <cerrno>
#include <cmath>
#include <cstring>
#include <memory>
#include <utility>

#include "firmware/io/file_source.hpp"
#include "slicer/mesh/edge_sum.hpp"
#include "slicer/reader/scan_reader.hpp"
#include "slicer/reader/triangles/mesh_reader.hpp"

namespace plumbline::firmware {
namespace {

class Collector final : public TriangleSink {
 public:
  Status take(std::span<const Triangle> triangles) override {
    all.insert(all.end(), triangles.begin(), triangles.end());
    return {};
  }
  bool progress(double /*fraction*/) override { return true; }
  void begin_body(BodyLabel body) override { negative |= body.is_negative(); }

  std::vector<Triangle> all;
  bool negative = false;
};

/// Rounds corners to 2^-30 of the longest side, so that those that are equal in the file stay equal.
bool is_closed(std::span<const Triangle> triangles) {
  Box3d box;
  for (const Triangle& triangle : triangles) {
    for (const Vec3d& corner : triangle) box.extend(corner);
  }
  const double longest = box.size().maxCoeff();
  const auto steps = [&](double mm) {
    return static_cast<std::int32_t>(longest > 0 ? std::floor(mm / longest * (1 << 30)) : 0);
  };
  const auto place = [&](const Vec3d& corner) {
    const Vec3d p = corner - box.low;
    return LatticePoint{steps(p[0]), steps(p[1]), steps(p[2])};
  };
  EdgeSum edges;
  for (const Triangle& t : triangles) edges.add({place(t[0]), place(t[1]), place(t[2])});
  return edges.is_closed();
}

constexpr std::size_t kPoints = 50'000;

/// Times the area.
Vec3d normal_of(const Triangle& t) { return Vec3d(t[1] - t[0]).cross(Vec3d(t[2] - t[0])) / 2; }

}  // namespace

Expected<TruthMesh> TruthMesh::read(const std::string& path) {
  constexpr const char* kAdvice = "Name a file with a closed mesh, such as an STL, or leave out --truth";
  // What the readers advise is about scans.
  const auto refuse = [](const Error& error) {
    const std::string_view found = error.finding();
    return fail(error.code(), "--truth: %.*s.\t%s", static_cast<int>(found.size()), found.data(), kAdvice);
  };
  if (::access(path.c_str(), R_OK) != 0) {
    return fail(ErrorCode::kCannotOpen, "--truth: %s: cannot be opened: %s.\t%s", path.c_str(), std::strerror(errno),
                kAdvice);
  }
  auto source = FileSource::open(path);
  if (!source) return refuse(source.error());
  // No format takes less than a byte for a vertex. What is not used costs nothing.
  const std::uint64_t vertices = source->size().value_or(1U << 22U) + 1;
  const std::size_t bytes = Arena::rounded(kReaderWorkspace) + VertexList::bytes_needed(vertices) + Arena::kAlignment;
  const auto memory = std::make_unique_for_overwrite<std::byte[]>(bytes);
  Arena arena(std::span(memory.get(), bytes));
  const auto workspace = arena.take_bottom<std::byte>(kReaderWorkspace, "truth");
  PLUMBLINE_TRY(workspace);
  auto list = VertexList::create(vertices, arena);
  PLUMBLINE_TRY(list);
  Collector found;
  const auto summary = read_mesh(*source, found, *list, *workspace);
  if (!summary) return refuse(summary.error());
  if (found.all.empty() || found.negative) {
    return fail(ErrorCode::kBadSetting, "--truth: %s: %s.\t%s", path.c_str(),
                found.negative ? "has negative volumes" : "has no triangles", kAdvice);
  }
  if (!is_closed(found.all)) {
    return fail(ErrorCode::kBadSetting,
                "--truth: %s: is not a closed surface: it has holes, or its triangles face different ways.\t%s",
                path.c_str(), kAdvice);
  }
  double volume = 0;
  const Vec3d origin = found.all[0][0];
  for (const Triangle& t : found.all) volume += normal_of(t).dot(t[0] - origin);
  if (volume < 0) {
    for (Triangle& t : found.all) std::swap(t[1], t[2]);
  }
  TruthMesh mesh;
  mesh.name_ = source->name();
  mesh.triangles_ = std::move(found.all);
  return mesh;
}

TrueSurface TruthMesh::surface(const Placement& placement) const {
  const auto area = [](const Triangle& t) {
    const Vec3d normal = normal_of(t);
    return std::sqrt(normal.dot(normal));
  };
  double whole = 0;
  for (const Triangle& t : triangles_) whole += area(t);
  TrueSurface surface{.name = name_, .points = {}};
  surface.points.reserve(kPoints);
  double before = 0;
  for (const Triangle& t : triangles_) {
    const double own = area(t);
    before += own;
    // The places in the triangles are those of a sequence of low discrepancy (M. Roberts 2018), folded into the triangle.
    for (;;) {
      const auto i = static_cast<double>(surface.points.size()) + 0.5;
      if (i >= before / whole * kPoints) break;
      double u = std::fmod(i * 0.7548776662466927, 1), v = std::fmod(i * 0.5698402909980532, 1);
      if (u + v > 1) u = 1 - u, v = 1 - v;
      const Vec3d at = t[0] + u * (t[1] - t[0]) + v * (t[2] - t[0]);
      const Vec3d print = placement.scale * Vec3d(placement.rotation * at) + placement.shift;
      const Vec3d normal = placement.rotation * Vec3d(normal_of(t) / own);
      surface.points.push_back({print.cast<float>(), normal.cast<float>()});
    }
  }
  return surface;
}

}  // namespace plumbline::firmware
