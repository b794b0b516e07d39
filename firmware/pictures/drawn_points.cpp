#include "firmware/pictures/drawn_points.hpp"

#include <algorithm>
#include <array>
#include <bit>
#include <cmath>

#include "firmware/pictures/preview/preview_smoothing.hpp"
#include "slicer/core/cell_table.hpp"
#include "slicer/placement/core_bounds.hpp"

namespace plumbline::firmware::inline pictures {
namespace {

constexpr const char* kStage = "picture of a scan";

/// Points of a cell's 3 x 3 x 3 neighbourhood; on a surface about this many, by the choice of the cells' edge.
constexpr float kAround = 24;
/// A point with fewer around it, itself among them, lies alone: at the edge of a sheet there are half of kAround, at its corner a quarter.
constexpr std::uint32_t kFewestAround = 4;
/// Area of a surface in such a neighbourhood, over the square of a cell's edge: 9 along an axis, more at an angle.
constexpr double kAreaAround = 10.5;

/// Radius of a disc over the distance of the points: by chance 1 % of the surface stays open.
constexpr double kDisc = 1.2;
constexpr double kLeastDisc = 0.75;  ///< samples: it covers one
constexpr double kRim = 2;           ///< samples that stay free around a view

/// Samples around one that tell whether it is a hole or a flying point.
constexpr std::size_t kRing = 8;

struct Cell {
  std::uint64_t key = 0;  ///< 0: empty
  std::uint32_t count = 0, around = 0;
};
using Cells = CellTable<Cell, &Cell::key>;

/// Counts the points around each cell. @returns the mean, over points
double count_around(const Cells& cells) {
  double sum = 0, points = 0;
  for (std::uint32_t i = 0; i < cells.size(); ++i) {
    if (!cells.occupied(i)) continue;
    for (std::uint32_t n = 0; n < 27; ++n) {
      cells[i].around += cells[cells.find_key(CellGrid::neighbour(cells[i].key, n))].count;
    }
    if (cells[i].around < kFewestAround) continue;
    sum += double{1} * cells[i].count * cells[i].around;
    points += cells[i].count;
  }
  return points > 0 ? sum / points : 1;
}

/// A filter that looks at eight samples around each.
struct Mending {
  std::ptrdiff_t ring;  ///< samples from its middle to those around
  std::size_t rank;     ///< how many of them may lie in front of the depths that a sample can have, and how many behind
  float tolerance;      ///< samples of depth that it may differ more
  bool settles_materials = false;  ///< gives it the material that most of them have
};

/// Brings a sample that is in front of nearly all of those around it, or behind, to the depth and material of the next one. With a wide
/// ring that removes flying points and closes holes but leaves edges and what is thin; with three of a narrow one it is a median.
void mend(const MapMemory& memory, const Mending& by) {
  const DepthMap& map = memory.map;
  std::ranges::copy(map.depth, memory.scratch.begin());
  const auto columns = static_cast<std::ptrdiff_t>(map.columns), rows = static_cast<std::ptrdiff_t>(map.rows);
  const std::ptrdiff_t ring = by.ring, slanted = (ring * 7 + 9) / 10;
  const std::array<std::array<std::ptrdiff_t, 2>, kRing> around{{{ring, 0},
                                                                 {-ring, 0},
                                                                 {0, ring},
                                                                 {0, -ring},
                                                                 {slanted, slanted},
                                                                 {-slanted, slanted},
                                                                 {slanted, -slanted},
                                                                 {-slanted, -slanted}}};
  for (std::ptrdiff_t y = 0; y < rows; ++y) {
    for (std::ptrdiff_t x = 0; x < columns; ++x) {
      struct Seen {
        float depth;
        std::uint8_t material;
      };
      std::array<Seen, kRing> seen;
      for (std::size_t k = 0; k < kRing; ++k) {
        const std::ptrdiff_t column = x + around[k][0], row = y + around[k][1];
        const bool outside = column < 0 || row < 0 || column >= columns || row >= rows;
        const auto at = static_cast<std::size_t>(row * columns + column);
        seen[k] = outside ? Seen{DepthMap::kEmpty, 0} : Seen{memory.scratch[at], map.material[at]};
      }
      std::ranges::sort(seen, {}, &Seen::depth);
      const Seen& near = seen[by.rank];
      const Seen& far = seen[kRing - 1 - by.rank];
      const auto at = static_cast<std::size_t>(y * columns + x);
      const float depth = memory.scratch[at];
      const Seen* const instead = depth < near.depth - by.tolerance  ? &near
                                  : depth > far.depth + by.tolerance ? &far
                                                                     : nullptr;
      if (instead != nullptr)
        map.show(static_cast<std::uint32_t>(x), static_cast<std::uint32_t>(y), instead->depth, instead->material != 0);
      if (!by.settles_materials) continue;
      int votes = map.material[at] == 0 ? -1 : 1;
      for (const Seen& other : seen) {
        if (other.depth != DepthMap::kEmpty) votes += other.material == 0 ? -1 : 1;
      }
      if (votes != 0) map.material[at] = votes < 0 ? 0 : 1;
    }
  }
}

}  // namespace

Expected<DrawnPoints> DrawnPoints::create(const Cloud& cloud, std::uint32_t most, Arena& arena) {
  const std::uint32_t step = (cloud.size - 1) / most + 1, count = (cloud.size - 1) / step + 1;
  DrawnPoints drawn;
  drawn.cloud_ = &cloud;
  const auto points = arena.take_top<std::uint32_t>(count, kStage);
  PLUMBLINE_TRY(points);
  for (std::uint32_t i = 0; i < count; ++i) (*points)[i] = i * step;
  drawn.points_ = *points;

  const ArenaScope scope(arena);
  const auto core = core_bounds(cloud.positions(), arena);
  PLUMBLINE_TRY(core);
  const auto object = dense_bounds(cloud.positions(), *core, arena);
  PLUMBLINE_TRY(object);
  drawn.object_ = *object;
  const float longest = object->size().maxCoeff();
  if (!(longest > 0 && longest < 1e30F)) return drawn;  // one point, or sums would overflow

  // A sphere as large as the object has 1.5 pi cells on its surface for the square of those along its diameter.
  const float edge = longest / std::max(1.0F, std::sqrt(static_cast<float>(count) / (kAround / 9 * 4.7F)));
  drawn.spacing_ = static_cast<double>(edge);
  const auto slots = arena.take_top<Cell>(std::bit_ceil(std::size_t{2} * count), kStage);
  PLUMBLINE_TRY(slots);
  const Cells cells(*slots);
  cells.clear();
  const Box3f reach{object->low - Vec3f::Constant(longest), object->high + Vec3f::Constant(longest)};
  const CellGrid grid(reach, edge);
  const auto is_near = [&](std::uint32_t i) {
    const auto p = cloud.position[i].array();
    return (p >= reach.low.array()).all() && (p <= reach.high.array()).all();
  };
  for (const std::uint32_t i : drawn.points_) {
    if (!is_near(i)) continue;
    const std::uint64_t key = grid.key(cloud.position[i]);
    Cell& cell = cells[cells.find_key(key)];
    cell.key = key;
    ++cell.count;
  }
  const double mean = count_around(cells);
  const auto lies_alone = [&](std::uint32_t i) {
    return !is_near(i) || cells[cells.find_key(grid.key(cloud.position[i]))].around < kFewestAround;
  };
  const auto alone = static_cast<std::size_t>(std::ranges::count_if(drawn.points_, lies_alone));
  // Where most points lie alone, there is no surface to tell the flying ones from.
  if (2 * alone > drawn.points_.size()) return drawn;
  const auto end = std::remove_if(drawn.points_.begin(), drawn.points_.end(), lies_alone);
  drawn.points_ = {drawn.points_.begin(), end};
  drawn.spacing_ = static_cast<double>(edge) * std::sqrt(kAreaAround / mean);
  return drawn;
}

ViewBox DrawnPoints::box(const Mat3d& rotation) const {
  const Vec3f margin = Vec3f::Constant(static_cast<float>(spacing_));
  const Vec3f low = object_.low - margin, high = object_.high + margin;
  ViewBox box{1e300, -1e300, 1e300, -1e300};
  for (const std::uint32_t i : points_) {
    const Vec3f& point = cloud_->position[i];
    if ((point.array() < low.array()).any() || (point.array() > high.array()).any()) continue;
    const Vec3d p = rotation * point.cast<double>();
    box = {std::min(box.left, p[0]), std::max(box.right, p[0]), std::min(box.low, p[2]), std::max(box.high, p[2])};
  }
  if (box.left > box.right) return {};
  return {box.left - spacing_, box.right + spacing_, box.low - spacing_, box.high + spacing_};
}

double DrawnPoints::scale(const ViewBox& box, const DepthMap& map) {
  return std::min((map.columns - 2 * kRim) / std::max(box.width(), 1e-12),
                  (map.rows - 2 * kRim) / std::max(box.height(), 1e-12));
}

void DrawnPoints::draw(const Mat3d& rotation, const ViewBox& box, double scale, const MapMemory& memory,
                       FunctionRef<bool(const Vec3d& normal)> is_second) const {
  const DepthMap& map = memory.map;
  const Vec3d middle = rotation * object_.centre().cast<double>();
  const double left = (box.left + box.right) / 2 * scale - 0.5 * map.columns;
  const double top = (box.low + box.high) / 2 * scale + 0.5 * map.rows;
  const double disc = std::clamp(kDisc * spacing_ * scale, kLeastDisc, std::max(1.0, map.columns / 16.0));
  std::fill(map.depth.begin(), map.depth.end(), DepthMap::kEmpty);
  const auto clamped = [](double v, std::uint32_t end) {
    return static_cast<std::uint32_t>(std::clamp<double>(v, 0, end));
  };
  for (const std::uint32_t i : points_) {
    const Vec3d p = rotation * cloud_->position[i].cast<double>();
    const bool second = is_second(rotation * cloud_->normal[i].unpack().cast<double>());
    const double x = p[0] * scale - left, y = top - p[2] * scale;
    const auto depth = static_cast<float>((p[1] - middle[1]) * scale);
    for (std::uint32_t row = clamped(y - disc, map.rows); row < clamped(y + disc + 1, map.rows); ++row) {
      for (std::uint32_t column = clamped(x - disc, map.columns); column < clamped(x + disc + 1, map.columns);
           ++column) {
        const double dx = column + 0.5 - x, dy = row + 0.5 - y;
        if (dx * dx + dy * dy > disc * disc || !(depth < map.at(column, row))) continue;
        map.show(column, row, depth, second);
      }
    }
  }
  // Wider than a disc, so that all around one lies outside it.
  const double ring = std::floor(2 * disc + 2);
  mend(memory, {.ring = static_cast<std::ptrdiff_t>(ring), .rank = 1, .tolerance = static_cast<float>(ring)});
  mend(memory, {.ring = 1, .rank = 3, .tolerance = 0, .settles_materials = true});
  const auto voxel = static_cast<float>(std::max(1.0, 1.5 * disc));
  smooth_depth(map, memory.scratch, {.across = voxel, .deep = voxel});
}

}  // namespace plumbline::firmware::inline pictures
