#include "slicer/stray_pieces.hpp"

#include <algorithm>
#include <array>
#include <span>

namespace plumbline {
namespace {

constexpr const char* kStage = "stray pieces";
constexpr std::uint32_t kSide = 32;  ///< cells along the longest side, and one for its end
constexpr std::size_t kMostCells = std::size_t{kSide + 1} * (kSide + 1) * (kSide + 1);
constexpr float kLeastEpsilons = 4;
constexpr double kSmall = 0.02;      ///< of the largest piece's area
constexpr double kAllStrays = 0.05;  ///< of the area of what stays
constexpr int kRounds = 8;

constexpr std::uint32_t kEmpty = ~std::uint32_t{0};

using Cell = std::array<std::uint32_t, 3>;

/// Occupied cells, joined to pieces.
class Cells {
 public:
  Cells(const Cloud& cloud, float epsilon, std::span<std::uint32_t> parent, std::span<double> area)
      : cloud_(cloud), parent_(parent), area_(area) {
    const Box3f box = cloud.bounds();
    low_ = box.low;
    const Vec3f size = box.size();
    const float longest = std::max({size[0], size[1], size[2]});
    const float cell = std::max(longest / kSide, kLeastEpsilons * epsilon);
    inverse_ = 1 / cell;
    for (int axis = 0; axis < 3; ++axis) {
      const auto a = static_cast<std::size_t>(axis);
      dims_[a] = std::min(kSide, static_cast<std::uint32_t>(size[axis] * inverse_)) + 1;
    }
    std::fill(parent_.begin(), parent_.end(), kEmpty);
    std::fill(area_.begin(), area_.end(), 0);
    for (std::uint32_t i = 0; i < cloud.size; ++i) {
      const std::uint32_t cell_of_point = index_of(i);
      parent_[cell_of_point] = cell_of_point;
      area_[cell_of_point] += static_cast<double>(cloud.radius[i]) * static_cast<double>(cloud.radius[i]);
    }
    join();
  }

  /// The cell of a point.
  std::uint32_t index_of(std::uint32_t point) const {
    Cell cell{};
    for (int axis = 0; axis < 3; ++axis) {
      const float at = (cloud_.position[point][axis] - low_[axis]) * inverse_;
      const auto a = static_cast<std::size_t>(axis);
      cell[a] = std::min(dims_[a] - 1, static_cast<std::uint32_t>(std::max(at, 0.0F)));
    }
    return index(cell);
  }
  bool occupied(std::uint32_t i) const { return parent_[i] != kEmpty; }
  std::uint32_t root(std::uint32_t i) const { return parent_[i]; }  ///< of an occupied cell; the piece's number
  bool is_root(std::uint32_t i) const { return parent_[i] == i; }
  double area(std::uint32_t root) const { return area_[root]; }

  template <class Visit>
  void for_each(Visit visit) const {
    Cell cell{};
    for (cell[2] = 0; cell[2] < dims_[2]; ++cell[2]) {
      for (cell[1] = 0; cell[1] < dims_[1]; ++cell[1]) {
        for (cell[0] = 0; cell[0] < dims_[0]; ++cell[0]) {
          const std::uint32_t i = index(cell);
          if (occupied(i)) visit(i, cell);
        }
      }
    }
  }

 private:
  std::uint32_t index(const Cell& cell) const { return (cell[2] * dims_[1] + cell[1]) * dims_[0] + cell[0]; }
  std::uint32_t find(std::uint32_t i) {
    while (parent_[i] != i) i = parent_[i] = parent_[parent_[i]];
    return i;
  }
  void join() {
    for_each([&](std::uint32_t i, const Cell& cell) {
      // Half of the 26 neighbours: those that come before it.
      for (std::uint32_t n = 0; n < 13; ++n) {
        const Cell step{n % 3, n / 3 % 3, n / 9};
        Cell other{};
        bool exists = true;
        for (std::size_t axis = 0; axis < 3; ++axis) {
          other[axis] = cell[axis] + step[axis] - 1;  // wraps to a large number below 0
          exists &= other[axis] < dims_[axis];
        }
        if (!exists || !occupied(index(other))) continue;
        const std::uint32_t a = find(i);
        const std::uint32_t b = find(index(other));
        parent_[std::max(a, b)] = std::min(a, b);
      }
    });
    for_each([&](std::uint32_t i, const Cell&) {
      parent_[i] = find(i);
      if (!is_root(i)) area_[parent_[i]] += area_[i];
    });
  }

  const Cloud& cloud_;
  std::span<std::uint32_t> parent_;
  std::span<double> area_;  ///< radius squared of the points; of a root all of its piece's
  Vec3f low_ = Vec3f::Zero();
  float inverse_ = 0;
  Cell dims_{};
};

/// Marks the roots of stray pieces. @returns how many there are, and their share of the area
StrayPieces find_strays(const Cells& cells, std::span<std::uint8_t> stays) {
  double largest = 0;
  cells.for_each([&](std::uint32_t i, const Cell&) {
    if (cells.is_root(i)) largest = std::max(largest, cells.area(i));
  });
  Cell low{kEmpty, kEmpty, kEmpty};
  Cell high{0, 0, 0};
  cells.for_each([&](std::uint32_t i, const Cell& cell) {
    stays[cells.root(i)] = cells.area(cells.root(i)) >= kSmall * largest ? 1 : 0;
    if (stays[cells.root(i)] == 0) return;
    for (std::size_t axis = 0; axis < 3; ++axis) {
      low[axis] = std::min(low[axis], cell[axis]);
      high[axis] = std::max(high[axis], cell[axis]);
    }
  });
  cells.for_each([&](std::uint32_t i, const Cell& cell) {
    bool near = true;
    for (std::size_t axis = 0; axis < 3; ++axis) near &= cell[axis] + 1 >= low[axis] && cell[axis] <= high[axis] + 1;
    if (near) stays[cells.root(i)] = 1;
  });
  StrayPieces strays;
  double kept = 0;
  double dropped = 0;
  cells.for_each([&](std::uint32_t i, const Cell&) {
    if (!cells.is_root(i)) return;
    (stays[i] != 0 ? kept : dropped) += cells.area(i);
    strays.pieces += stays[i] != 0 ? 0 : 1;
  });
  if (!(dropped < kAllStrays * kept)) return {};
  strays.share = static_cast<float>(dropped / (dropped + kept));
  return strays;
}

/// @returns points dropped
std::uint32_t drop(Cloud& cloud, const Cells& cells, std::span<const std::uint8_t> stays) {
  // The cells know the points by their places: those first, while every point still has its own.
  for (std::uint32_t i = 0; i < cloud.size; ++i) {
    if (stays[cells.root(cells.index_of(i))] == 0) cloud.normal[i].point_class = PointClass::kNoise;
  }
  const std::uint32_t before = cloud.size;
  cloud.drop_noise();
  return before - cloud.size;
}

}  // namespace

std::size_t stray_pieces_bytes() {
  return Arena::rounded(kMostCells * sizeof(std::uint32_t)) + Arena::rounded(kMostCells * sizeof(double)) +
         Arena::rounded(kMostCells);
}

Expected<StrayPieces> drop_stray_pieces(Cloud& cloud, float epsilon, Arena& arena) {
  const ArenaScope scope(arena);
  const auto parent = arena.take_top<std::uint32_t>(kMostCells, kStage);
  PLUMBLINE_TRY(parent);
  const auto area = arena.take_top<double>(kMostCells, kStage);
  PLUMBLINE_TRY(area);
  const auto stays = arena.take_top<std::uint8_t>(kMostCells, kStage);
  PLUMBLINE_TRY(stays);
  StrayPieces all;
  for (int round = 0; round < kRounds; ++round) {
    const Cells cells(cloud, epsilon, *parent, *area);
    const StrayPieces found = find_strays(cells, *stays);
    if (found.pieces == 0) break;
    all.pieces += found.pieces;
    all.share += (1 - all.share) * found.share;
    all.points += drop(cloud, cells, *stays);
  }
  return all;
}

}  // namespace plumbline
