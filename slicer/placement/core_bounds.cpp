#include "slicer/placement/core_bounds.hpp"

#include <algorithm>
#include <cmath>
#include <cstdint>

#include "slicer/core/cell_pieces.hpp"

namespace plumbline::inline slicer {
namespace {

// Cells along the core's longest side: so many that a surface has about ten points a cell.
constexpr float kMostCells = 64;
constexpr float kFewestCells = 8;
constexpr float kPointsPerCell2 = 48;  ///< points over cells squared; a sphere of n cells has 1.5 pi n^2 on its surface
constexpr float kFewest = 4;           ///< points of a cell
constexpr std::uint32_t kAverageShare = 16;      ///< a cell with fewer than the average over this holds no surface
constexpr std::uint32_t kCoreSlots = 1U << 15U;  ///< of the table; surfaces fill some 10,000

}  // namespace

Expected<Box3f> core_bounds(std::span<const Vec3f> points, Arena& arena) {
  const ArenaScope scope(arena);
  const auto sorted = arena.take_top<float>(points.size(), "reading the scan");
  PLUMBLINE_TRY(sorted);
  const auto left_out = static_cast<std::ptrdiff_t>(points.size() / 20);
  Box3f box;
  for (int axis = 0; axis < 3; ++axis) {
    std::transform(points.begin(), points.end(), sorted->begin(), [axis](const Vec3f& p) { return p[axis]; });
    const auto lowest = sorted->begin() + left_out;
    std::nth_element(sorted->begin(), lowest, sorted->end());
    box.low[axis] = *lowest;
    const auto highest = sorted->end() - 1 - left_out;
    std::nth_element(lowest, highest, sorted->end());
    box.high[axis] = *highest;
  }
  return box;
}

Expected<Box3f> dense_bounds(std::span<const Vec3f> points, const Box3f& core, Arena& arena) {
  const ArenaScope scope(arena);
  const auto slots = arena.take_top<CellPieces::Cell>(kCoreSlots, "reading the scan");
  PLUMBLINE_TRY(slots);
  Box3f all;
  for (const Vec3f& p : points) all.extend(p);
  const float longest = core.size().maxCoeff();
  if (!(longest > 0)) return all;
  // Points farther away than the core is long are in no cell.
  Box3f reach;
  reach.extend((core.low - Vec3f::Constant(longest)).cwiseMax(all.low));
  reach.extend((core.high + Vec3f::Constant(longest)).cwiseMin(all.high));
  const float cells =
      std::clamp(std::sqrt(static_cast<float>(points.size()) / kPointsPerCell2), kFewestCells, kMostCells);
  CellPieces pieces(reach, longest / cells, *slots);
  const auto inside = [&](const Vec3f& p) {
    return (p.array() >= reach.low.array()).all() && (p.array() <= reach.high.array()).all();
  };
  for (const Vec3f& p : points) {
    if (inside(p) && !pieces.add(p, 1)) return all;
  }
  const std::size_t share = points.size() / (std::size_t{kAverageShare} * pieces.occupied());
  pieces.join(std::max(kFewest, static_cast<float>(share)));
  std::uint32_t largest = kCoreSlots;
  for (std::uint32_t i = 0; i < kCoreSlots; ++i) {
    if (!pieces.is_piece(i)) continue;
    if (largest == kCoreSlots || pieces.amount(i) > pieces.amount(largest)) largest = i;
  }
  if (largest == kCoreSlots || pieces.amount(largest) < kFewest) return all;
  Box3f box;
  for (const Vec3f& p : points) {
    if (inside(p) && pieces.piece_of(p) == largest) box.extend(p);
  }
  return box;
}

}  // namespace plumbline::inline slicer
