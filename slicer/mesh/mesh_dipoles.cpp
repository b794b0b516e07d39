#include "slicer/mesh/mesh_dipoles.hpp"

#include <algorithm>
#include <array>
#include <bit>
#include <cmath>
#include <numbers>

#include "slicer/cloud/kd_tree.hpp"
#include "slicer/implicit/winding_number.hpp"

namespace plumbline::inline slicer {
namespace {

constexpr const char* kStage = "winding number";
constexpr std::uint32_t kFewestSlots = 1U << 10U;
/// A surface passes through about 2 cells for every square of a cell's side, and half of the slots are to stay empty.
constexpr double kSlotsPerSquare = 4;
/// Cells along the longest side. Finer ones would cut long slivers into patches without end.
constexpr float kMostCells = 2048;

/// A fuller table is slow.
constexpr std::uint32_t most_used(std::uint32_t slots) { return slots / 3 * 2; }

float length2(const Vec3f& a, const Vec3f& b) { return (b - a).dot(b - a); }

}  // namespace

std::uint32_t MeshDipoles::slots_in(std::size_t available) {
  const std::size_t room = available / 4 / sizeof(Cell);
  return static_cast<std::uint32_t>(std::clamp<std::size_t>(std::bit_floor(room), kFewestSlots, kMostSlots));
}

std::size_t MeshDipoles::reading_bytes(std::uint32_t slots) {
  const std::size_t points = most_used(slots);
  return Arena::rounded(slots * sizeof(Cell)) + points * (Cloud::kBytesPerPoint + KdTree3::kBytesPerPoint);
}

std::size_t MeshDipoles::field_bytes(std::uint32_t slots) {
  const std::uint32_t points = most_used(slots);
  return points * Cloud::kBytesPerPoint + WindingTree::bytes_needed(points);
}

Expected<MeshDipoles> MeshDipoles::create(const Box3f& box, double area, Arena& arena) {
  const std::uint32_t slots = slots_in(arena.available());
  const auto cells = arena.take_bottom<Cell>(slots, kStage);
  PLUMBLINE_TRY(cells);
  MeshDipoles dipoles;
  dipoles.table_ = Table(*cells);
  dipoles.box_ = box;
  dipoles.cell_ = 0.5F * std::max(static_cast<float>(std::sqrt(kSlotsPerSquare * area / static_cast<double>(slots))),
                                  box.size().maxCoeff() / kMostCells);
  dipoles.double_cells();
  return dipoles;
}

void MeshDipoles::double_cells() {
  constexpr float kShortest = 1e-6F;  // mm; keeps a flat mesh from cells without a size
  cell_ = std::max(2 * cell_, kShortest);
  grid_.emplace(box_, cell_);
  table_.clear();
  used_ = 0;
}

bool MeshDipoles::add(const Vec3d& a, const Vec3d& b, const Vec3d& c) {
  // Halves the longest edge until it is no longer than a cell. The three edges of a triangle are halved some 3 * 11 times.
  struct Part {
    std::array<Vec3f, 3> p;
  };
  std::array<Part, 64> stack;
  std::size_t parts = 0;
  stack[parts++] = {{a.cast<float>(), b.cast<float>(), c.cast<float>()}};
  while (parts > 0) {
    const auto p = stack[--parts].p;
    std::size_t longest = 0;
    float most = 0;
    for (std::size_t e = 0; e < 3; ++e) {
      const float edge = length2(p[e], p[(e + 1) % 3]);
      if (edge > most) {
        most = edge;
        longest = e;
      }
    }
    if (most <= cell_ * cell_ || parts + 2 > stack.size()) {
      const Vec3f directed = 0.5F * (p[1] - p[0]).cross(p[2] - p[0]);
      if (!add_patch((p[0] + p[1] + p[2]) / 3.0F, directed)) return false;
      continue;
    }
    const Vec3f& from = p[longest];
    const Vec3f& to = p[(longest + 1) % 3];
    const Vec3f& across = p[(longest + 2) % 3];
    const Vec3f middle = 0.5F * (from + to);
    stack[parts++] = {{middle, to, across}};
    stack[parts++] = {{from, middle, across}};
  }
  return true;
}

bool MeshDipoles::add_patch(const Vec3f& centre, const Vec3f& directed) {
  const float area = std::sqrt(directed.dot(directed));
  if (!(area > 0)) return true;
  const Vec3f inside = centre.cwiseMax(box_.low).cwiseMin(box_.high);
  const std::uint64_t key = grid_->key(inside);
  const std::uint32_t slot = table_.find_key(key);
  Cell& cell = table_[slot];
  if (cell.key == 0) {
    if (used_ >= most_used(table_.size())) return false;
    ++used_;
    cell.key = key;
  }
  cell.area += area;
  cell.weighted += area * inside;
  cell.directed += directed;
  return true;
}

Expected<Cloud> MeshDipoles::to_cloud(Arena& arena) const {
  auto cloud = Cloud::create(used_, arena);
  PLUMBLINE_TRY(cloud);
  for (std::uint32_t i = 0; i < table_.size(); ++i) {
    const Cell& cell = table_[i];
    const float area = std::sqrt(cell.directed.dot(cell.directed));
    if (cell.key == 0 || !(area > 0)) continue;
    PackedNormal normal;
    normal.set(cell.directed / area);
    normal.point_class = PointClass::kNeutral;
    cloud->position[cloud->size] = cell.weighted / cell.area;
    cloud->normal[cloud->size] = normal;
    cloud->radius[cloud->size] = std::sqrt(area * std::numbers::inv_pi_v<float>);
    ++cloud->size;
  }
  if (cloud->size == 0) return cloud;
  const ArenaScope scope(arena);
  auto tree = KdTree3::build(cloud->positions(), arena, kStage);
  PLUMBLINE_TRY(tree);
  cloud->reorder(tree->order());
  return cloud;
}

}  // namespace plumbline::inline slicer
