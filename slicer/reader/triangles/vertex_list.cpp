#include "slicer/reader/triangles/vertex_list.hpp"

namespace plumbline::inline slicer {
namespace {

constexpr const char* kStage = "mesh";

std::size_t words(std::uint64_t vertices) { return static_cast<std::size_t>((vertices + 63) / 64); }

}  // namespace

std::size_t VertexList::bytes_needed(std::uint64_t vertices) {
  return Arena::rounded(static_cast<std::size_t>(vertices) * sizeof(Vec3f)) +
         Arena::rounded(words(vertices) * sizeof(std::uint64_t));
}

std::uint64_t VertexList::most_in(std::size_t bytes) {
  constexpr std::size_t kBits = 8 * sizeof(Vec3f) + 1;  // of a vertex
  constexpr std::size_t kSlack = 4 * Arena::kAlignment;
  return bytes <= kSlack ? 0 : std::uint64_t{bytes - kSlack} * 8 / kBits;
}

Expected<VertexList> VertexList::create(std::uint64_t capacity, Arena& arena) {
  const auto positions = arena.take_bottom<Vec3f>(static_cast<std::size_t>(capacity), kStage);
  PLUMBLINE_TRY(positions);
  const auto bits = arena.take_bottom<std::uint64_t>(words(capacity), kStage);
  PLUMBLINE_TRY(bits);
  VertexList list;
  list.positions_ = *positions;
  list.bits_ = *bits;
  list.clear();
  return list;
}

void VertexList::clear() {
  size_ = 0;
  used_ = 0;
}

Vec3d VertexList::origin_at(const Vec3d& p) {
  Vec3d origin = Vec3d::Zero();
  for (int axis = 0; axis < 3; ++axis) origin[axis] = std::abs(p[axis]) <= kLargestOffset ? p[axis] : 0;
  return origin;
}

}  // namespace plumbline::inline slicer
