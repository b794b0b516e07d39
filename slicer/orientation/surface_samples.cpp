#include "slicer/orientation/surface_samples.hpp"

#include <algorithm>
#include <cmath>
#include <cstdint>

#include "slicer/core/cell_table.hpp"
#include "slicer/placement/core_bounds.hpp"

namespace plumbline::inline slicer {
namespace {

constexpr const char* kStage = "orientation";
constexpr std::uint32_t kMostSampled = 1U << 17U;
constexpr std::uint32_t kSampleSlots = 1U << 14U;  ///< of the table; surfaces fill some 7,000
// Cells along the longest side: so many that a patch has about ten points.
constexpr float kPointsPerCell2 = 48;
constexpr float kFewestCells = 12;
constexpr float kMostCells = 48;
constexpr float kAround = 0.3F;      ///< of the core's longest side; the object reaches no farther beyond the core
constexpr float kFewPoints = 0.15F;  ///< of the average; cells with fewer are at edges, or hold flying points
constexpr float kMostQuality = 2;

struct Cell {
  std::uint64_t key = 0;  ///< 0: empty; that of the cell, times 8, and the side that it faces
  std::uint32_t points = 0;
  Vec3f position = Vec3f::Zero();  ///< sum
  Vec3f normal = Vec3f::Zero();    ///< sum
};

/// 0 to 5: the axis along which a vector is longest, and its sign.
std::uint64_t side_of(const Vec3f& n) {
  int axis = 0;
  n.cwiseAbs().maxCoeff(&axis);
  return 2 * static_cast<std::uint64_t>(axis) + (n[axis] < 0 ? 1 : 0);
}

}  // namespace

float SurfaceSamples::hole_share() const { return area > 0 ? std::sqrt(hole.dot(hole)) / area : 0; }

std::size_t sample_surface_bytes(std::uint32_t points) {
  return std::max(Arena::rounded(sizeof(float) * std::size_t{points}),  // core_bounds()
                  Arena::rounded(kSampleSlots * sizeof(Cell)) + Arena::rounded(kSampleSlots * sizeof(SurfaceSample)));
}

Expected<SurfaceSamples> sample_surface(const Cloud& cloud, Arena& arena) {
  const auto core = core_bounds(cloud.positions(), arena);
  PLUMBLINE_TRY(core);
  const auto slots = arena.take_top<Cell>(kSampleSlots, kStage);
  PLUMBLINE_TRY(slots);
  const auto patches = arena.take_top<SurfaceSample>(kSampleSlots, kStage);
  PLUMBLINE_TRY(patches);
  const float longest = std::max(core->size().maxCoeff(), 1e-12F);
  Box3f reach;
  reach.extend(core->low - Vec3f::Constant(kAround * longest));
  reach.extend(core->high + Vec3f::Constant(kAround * longest));
  const std::uint32_t step = cloud.size / kMostSampled + 1;
  const float count = static_cast<float>(cloud.size) / static_cast<float>(step);
  const CellTable<Cell, &Cell::key> table(*slots);
  SurfaceSamples samples;
  std::uint32_t occupied = 0;
  std::uint32_t inside = 0;
  // Cells grow until the table holds them.
  for (float cells = std::clamp(std::sqrt(count / kPointsPerCell2), kFewestCells, kMostCells);; cells *= 0.75F) {
    samples.cell = longest / cells;
    const CellGrid grid(reach, samples.cell);
    table.clear();
    occupied = 0;
    inside = 0;
    for (std::uint32_t i = 0; i < cloud.size && occupied <= kSampleSlots * 2 / 3; i += step) {
      const Vec3f& p = cloud.position[i];
      const bool near = (p.array() > reach.low.array()).all() && (p.array() < reach.high.array()).all();
      if (!near || !cloud.normal[i].known()) continue;
      const Vec3f n = cloud.normal[i].unpack();
      const std::uint64_t key = grid.key(p) << 3U | side_of(n);
      const std::uint32_t at = table.find_key(key);
      if (!table.occupied(at)) {
        ++occupied;
        table[at].key = key;
      }
      ++inside;
      ++table[at].points;
      table[at].position += p;
      table[at].normal += n;
    }
    if (occupied <= kSampleSlots * 2 / 3) break;
  }
  const float average = static_cast<float>(inside) / static_cast<float>(std::max(1U, occupied));
  std::size_t used = 0;
  double area = 0;
  for (std::uint32_t i = 0; i < kSampleSlots; ++i) {
    const Cell& cell = table[i];
    const auto points = static_cast<float>(cell.points);
    const float length = std::sqrt(cell.normal.dot(cell.normal));
    if (!table.occupied(i) || points < kFewPoints * average || !(length > 0.3F * points)) continue;
    SurfaceSample& patch = (*patches)[used++];
    patch.position = cell.position / points;
    patch.normal = cell.normal / length;
    patch.area = samples.cell * samples.cell / patch.normal.lpNorm<1>();
    patch.quality = points / patch.area;
    area += static_cast<double>(patch.area);
  }
  samples.patches = patches->first(used);
  samples.area = static_cast<float>(area);
  Vec3d sum = Vec3d::Zero();
  for (SurfaceSample& patch : patches->first(used)) {
    patch.quality = std::min(kMostQuality, patch.quality * samples.area / std::max(1.0F, static_cast<float>(inside)));
    sum += (patch.area * patch.normal).cast<double>();
  }
  samples.hole = -sum.cast<float>();
  return samples;
}

}  // namespace plumbline::inline slicer
