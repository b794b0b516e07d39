#include "slicer/mesh/outline_shift.hpp"

#include <algorithm>
#include <cmath>

namespace plumbline::inline slicer {
namespace {

/// Slots beside three for four triangles: small bodies have more corners for a triangle, a tetrahedron one.
constexpr std::size_t kSpareSlots = 4096;

/// Share of the normals' sum of squares below which a direction is left free (Tikhonov).
constexpr double kFree = 1e-5;

std::size_t slots_for(std::uint64_t triangles) { return static_cast<std::size_t>(triangles / 4 * 3) + kSpareSlots; }

std::uint64_t hash_of(const LatticePoint& p) {
  std::uint64_t hash = static_cast<std::uint32_t>(p.x);
  for (const std::int32_t next : {p.y, p.z}) {
    hash = (hash ^ hash >> 29U) * 0x9E3779B97F4A7C15U + static_cast<std::uint32_t>(next);  // Fibonacci hashing
  }
  hash = (hash ^ hash >> 32U) * 0xD6E8FEB86659FD93U;
  return hash ^ hash >> 32U;
}

}  // namespace

std::size_t OutlineShift::bytes_needed(std::uint64_t triangles) {
  return Arena::rounded(slots_for(triangles) * sizeof(Corner));
}

Expected<OutlineShift> OutlineShift::create(std::uint64_t triangles, Arena& arena) {
  OutlineShift shift;
  PLUMBLINE_TRY(arena.take_top(shift.slots_, slots_for(triangles), "mesh"));
  shift.clear();
  return shift;
}

void OutlineShift::clear() {
  std::ranges::fill(slots_, Corner{{-1, 0, 0}, {}, Vec3f::Zero()});
  used_ = 0;
}

OutlineShift::Corner& OutlineShift::slot_of(const LatticePoint& corner) const {
  std::size_t i = static_cast<std::size_t>((hash_of(corner) & 0xFFFFFFFFU) * std::uint64_t{slots_.size()} >> 32U);
  while (slots_[i].at.x >= 0 && slots_[i].at != corner) i = i + 1 < slots_.size() ? i + 1 : 0;
  return slots_[i];
}

bool OutlineShift::add(const LatticeTriangle& corners, const std::array<Vec3d, 3>& print_mm) {
  const auto side = [&](std::size_t from, std::size_t to) { return Vec3d(print_mm[to] - print_mm[from]); };
  const Vec3d across = side(0, 1).cross(side(0, 2));
  const double twice_area = std::sqrt(across.dot(across));
  if (!(twice_area > 0)) return true;
  const Vec3d n = across / twice_area;
  const double level = std::sqrt(n[0] * n[0] + n[1] * n[1]);
  for (std::size_t i = 0; i < 3; ++i) {
    const Vec3d one = side(i, (i + 1) % 3), other = side(i, (i + 2) % 3);
    const double weight = twice_area / std::sqrt(one.dot(one) * other.dot(other));
    Corner& corner = slot_of(corners[i]);
    if (corner.at.x < 0) {
      if (used_ >= slots_.size() / 16 * 15) return false;
      ++used_;
      corner.at = corners[i];
    }
    std::size_t k = 0;
    for (int row = 0; row < 3; ++row) {
      for (int column = row; column < 3; ++column) corner.nn[k++] += static_cast<float>(weight * n[row] * n[column]);
    }
    corner.n += Vec3d(weight * level * n).cast<float>();
  }
  return true;
}

void OutlineShift::solve(double by_mm, const Vec3d& step) {
  const double most = kMitre * std::abs(by_mm);
  for (Corner& corner : slots_) {
    if (corner.at.x < 0) continue;
    const auto at = [&](std::size_t i) { return static_cast<double>(corner.nn[i]); };
    const double free = kFree * (at(0) + at(3) + at(5));
    const Vec3d x(at(0) + free, at(1), at(2)), y(at(1), at(3) + free, at(4)), z(at(2), at(4), at(5) + free);
    const Vec3d n = corner.n.cast<double>();
    // Cramer's rule. With `free` in it the matrix is positive definite.
    const Vec3d yz = y.cross(z), zx = z.cross(x), xy = x.cross(y);
    Vec3d move = Vec3d(yz * n[0] + zx * n[1] + xy * n[2]) * (by_mm / x.dot(yz));
    const double length = std::sqrt(move.dot(move));
    if (length > most) move *= most / length;
    corner.n = Vec3d(move.cwiseQuotient(step)).cast<float>();
  }
}

std::array<std::int64_t, 3> OutlineShift::move_of(const LatticePoint& corner) const {
  const Corner& found = slot_of(corner);
  if (found.at.x < 0) return {};
  const auto steps = [&](int axis) { return static_cast<std::int64_t>(std::floor(found.n[axis] + 0.5F)); };
  return {steps(0), steps(1), steps(2)};
}

LatticePoint MeshLattice::moved(const LatticePoint& p) const {
  const auto move = shift_->move_of(p);
  const auto put = [&](std::int32_t from, int axis) {
    const auto last = static_cast<std::int64_t>(last_[axis]);
    return static_cast<std::int32_t>(std::clamp<std::int64_t>(from + move[static_cast<std::size_t>(axis)], 0, last));
  };
  return {put(p.x, 0), put(p.y, 1), put(p.z, 2)};
}

}  // namespace plumbline::inline slicer
