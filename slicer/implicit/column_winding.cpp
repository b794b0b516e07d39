#include "slicer/implicit/column_winding.hpp"

#include <algorithm>
#include <cmath>

#include "slicer/core/numbers/lanes.hpp"

namespace plumbline::inline slicer {
namespace {

/// Of what fills up the last lanes: not 0, by which the lean divides.
constexpr float kNoArea = 1e-30F;

/// kLanes dipoles, seen from a place.
struct SeenDipoles {
  Lanes distance2;  ///< with the softening, mm^2
  Lanes distance;   ///< mm
  Lanes outwards;   ///< the dipole times the way to it
};
PLUMBLINE_INLINE void see(SeenDipoles& seen, const DipoleList& list, std::uint32_t at, const Vec3f& place) {
  Lanes x, y, z, dipole_x, dipole_y, dipole_z, softening;
  load(x, list.x + at);
  load(y, list.y + at);
  load(z, list.z + at);
  load(dipole_x, list.dipole_x + at);
  load(dipole_y, list.dipole_y + at);
  load(dipole_z, list.dipole_z + at);
  load(softening, list.softening + at);
  x -= place[0];
  y -= place[1];
  z -= place[2];
  seen.distance2 = x * x + y * y + z * z + softening;
  square_root(seen.distance, seen.distance2);
  seen.outwards = dipole_x * x + dipole_y * y + dipole_z * z;
}

PLUMBLINE_WIDE void add_up(const DipoleList& list, const Vec3f& place, float& winding) {
  Lanes sums{};
  for (std::uint32_t j = 0; j < list.size; j += kLanes) {
    SeenDipoles seen;
    see(seen, list, j, place);
    sums += seen.outwards / (seen.distance2 * seen.distance);
  }
  winding = sum(sums);
}

PLUMBLINE_WIDE void add_up_lean(const DipoleList& list, const Vec3f& place, WindingLean& lean) {
  Lanes outwards{};
  Lanes weights{};
  for (std::uint32_t j = 0; j < list.size; j += kLanes) {
    SeenDipoles seen;
    see(seen, list, j, place);
    Lanes area;
    load(area, list.area + j);
    const Lanes towards = seen.outwards / (area * seen.distance);
    const Lanes weight = area / (seen.distance2 * seen.distance2);
    weights += weight;
    outwards += weight * towards * (1.0F - towards * towards);
  }
  lean = {sum(outwards), sum(weights)};
}

}  // namespace

std::size_t ColumnWinding::bytes_needed() { return Arena::rounded(kColumns * kPool * sizeof(float)); }

Expected<ColumnWinding> ColumnWinding::create(const WindingTree& tree, Arena& arena) {
  ColumnWinding winding;
  PLUMBLINE_TRY(arena.take_top(winding.pool_, kColumns * kPool, "winding number"));
  winding.tree_ = &tree;
  return winding;
}

void ColumnWinding::begin(const Vec2f& low, const Vec2f& high) {
  low_ = low;
  high_ = high;
  const Vec2f side = high - low;
  cell_height_ = std::max({side[0], side[1], std::numeric_limits<float>::min()});
  clear();
}

void ColumnWinding::clear() {
  cells_.fill({});
  used_ = 0;
}

/// The cell that a place is in; null where none is kept.
ColumnWinding::Cell* ColumnWinding::cell_at(const Vec3f& x) {
  const float number = std::floor(x[2] / cell_height_);
  if (!(std::abs(number) < 1e9F)) return nullptr;
  const auto cell_number = static_cast<std::int32_t>(number);
  Cell& cell = cells_[static_cast<std::uint32_t>(cell_number) % kCells];
  if (cell.number != cell_number) cell = {.number = cell_number};
  return &cell;
}

/// The dipoles for a place: none if they are too many.
std::optional<DipoleList> ColumnWinding::list_at(const Vec3f& x) {
  Cell* const cell = cell_at(x);
  if (cell == nullptr) return std::nullopt;
  if (!cell->gathered) {
    const std::int32_t number = cell->number;
    const bool whole = used_ == 0;
    if (!gather(number, *cell) && !whole) {
      clear();
      gather(number, *cell);
    }
  }
  if (cell->size == 0) return std::nullopt;
  const auto at = [&](std::size_t i) -> const float* { return column(i) + cell->first; };
  return DipoleList{at(0), at(1), at(2), at(3), at(4), at(5), at(6), at(7), cell->size};
}

/// @param cell  out: without dipoles if there is no room
/// @returns whether there is
bool ColumnWinding::gather(std::int32_t number, Cell& cell) {
  const auto below = static_cast<float>(number);
  Box3f box;
  box.extend(Vec3f(low_[0], low_[1], below * cell_height_));
  box.extend(Vec3f(high_[0], high_[1], (below + 1) * cell_height_));
  std::uint32_t end = used_;
  bool room = true;
  const auto put = [&](const Vec3f& place, const Vec3f& dipole, float area, float softening) {
    room &= end < kPool;
    if (!room) return;
    column(0)[end] = place[0];
    column(1)[end] = place[1];
    column(2)[end] = place[2];
    column(3)[end] = dipole[0];
    column(4)[end] = dipole[1];
    column(5)[end] = dipole[2];
    column(6)[end] = area;
    column(7)[end] = softening;
    ++end;
  };
  tree_->for_each_dipole(box, [&](const Vec3f& place, const Vec3f& dipole, float softening) {
    const float area = std::sqrt(dipole.dot(dipole));
    if (area > 0) put(place, dipole, area, softening);
  });
  const Vec3f beside(box.high[0] + 1, box.high[1], box.high[2]);
  while (room && end % kLanes != 0) put(beside, Vec3f::Zero(), kNoArea, 0);
  cell = {.number = number, .first = used_, .size = room ? end - used_ : 0, .gathered = true};
  if (room) used_ = end;
  return room;
}

float ColumnWinding::operator()(const Vec3f& x) {
  if (x[2] < tree_->base()) return 0;
  const auto list = list_at(x);
  if (!list) return (*tree_)(x);
  float winding = 0;
  add_up(*list, x, winding);
  return winding;
}

float ColumnWinding::beyond(const Vec3f& x, float margin) {
  Cell* const cell = cell_at(x);
  if (cell != nullptr && !cell->gathered && cell->rough++ < kMostRough) {
    const float rough = tree_->rough(x);
    if (std::abs(rough - WindingTree::kSurface) > margin + WindingTree::kRough) return rough;
  }
  return (*this)(x);
}

bool ColumnWinding::inside(const Vec3f& x, float winding) {
  if (WindingTree::is_plain(winding)) return winding > WindingTree::kSurface;
  const auto list = list_at(x);
  if (!list) return tree_->inside(x, winding);
  WindingLean lean;
  add_up_lean(*list, x, lean);
  return lean.inside(winding);
}

float ColumnWinding::surface_between(float x, float y, float from, float to, bool inside_at_from, float tolerance) {
  constexpr int kBisections = 8;  // leave a 256th of the interval
  for (int i = 0; i < kBisections && std::abs(to - from) > tolerance; ++i) {
    const float middle = 0.5F * (from + to);
    (inside({x, y, middle}) == inside_at_from ? from : to) = middle;
  }
  return 0.5F * (from + to);
}

}  // namespace plumbline::inline slicer
