#pragma once
/// The shells of a mesh: which triangles hang together, which of them are turned over, and which are there more than once.

#include <array>
#include <cstdint>
#include <span>

#include "slicer/core/arena.hpp"
#include "slicer/mesh/edge_sum.hpp"
#include "slicer/mesh/hit_list.hpp"
#include "slicer/mesh/mesh_lattice.hpp"

namespace plumbline::inline slicer {

/// One side of a triangle, as it runs along an edge.
struct EdgeUse {
  std::uint64_t edge = 0;  ///< EdgeSum::number_of_edge()
  std::uint32_t face = 0;  ///< equal for triangles with the same corners
  std::uint32_t use = 0;   ///< twice the triangle's number, and 1 if it runs from the higher to the lower corner
  auto operator<=>(const EdgeUse&) const = default;  // NOLINT(modernize-use-nullptr): compares with literal 0
};

/// What is known of a shell.
struct Shell {
  EdgeSum edges;
  std::int64_t volume = 0;  ///< pixels times layers, of the rays on which it is closed; negative: inside out
  std::int64_t votes = 0;   ///< hits on faces that were not turned, less those on turned ones
  std::uint64_t hits = 0;
  std::uint32_t body = 0;                    ///< of its triangles
  std::int64_t inside = 0;                   ///< winding number in it, by itself and the shells around it
  bool turns = false;                        ///< all of it is turned over, once more
  bool reversed = false;                     ///< the way that most of its faces had is turned over
  bool seen = false;                         ///< `around` is set
  std::uint8_t count = 0;                    ///< of `around`
  std::array<std::uint32_t, 6> around = {};  ///< larger shells that all of it lies in
};

/// Joins triangles to shells, over the edges that they share (union-find, with the side of each triangle relative to its root's).
///
/// An edge of two triangles joins them: they run along it in opposite directions if both face the same side of the surface. Triangles with
/// the same corners count as one. If they are an even number, they may also cancel: where two boxes touch, both have the face between them,
/// and neither is wanted; of a double-sided sheet one side is. The edges tell: a surface that is closed without such a face needs none.
/// An edge of four or more triangles joins only what is not closed there by itself.
class ShellJoiner {
 public:
  static constexpr std::uint64_t kMostTriangles = std::uint64_t{1} << 30U;
  static std::size_t bytes_needed(std::uint64_t triangles);

  /// @param triangles  at most kMostTriangles
  /// @param arena      bytes_needed() from the bottom; the caller releases them
  /// @retval ErrorCode::kOutOfMemory
  [[nodiscard]] static Expected<ShellJoiner> create(std::uint64_t triangles, Arena& arena);

  /// Calls visit(EdgeUse) for the sides of a triangle. One with two corners in one place has none.
  /// @param body  of it: triangles of different bodies share no edge
  template <class Visit>
  static void for_each_use(const LatticeTriangle& t, std::uint32_t number, std::uint32_t body, Visit visit) {
    if (t[0] == t[1] || t[1] == t[2] || t[2] == t[0]) return;
    std::array<std::uint64_t, 3> corner;
    for (std::size_t i = 0; i < 3; ++i) corner[i] = mix64(EdgeSum::number_of(t[i]) + body * kGoldenStep64);
    const auto face = static_cast<std::uint32_t>(mix64(corner[0] + corner[1] + corner[2]));
    for (std::size_t i = 0; i < 3; ++i) {
      const std::uint64_t from = corner[i];
      const std::uint64_t to = corner[(i + 1) % 3];
      visit(EdgeUse{EdgeSum::number_of_edge(from, to), face, number << 1U | (from < to ? 0U : 1U)});
    }
  }

  /// Joins triangles over edges of two faces; afterwards, once more for all edges, over the others.
  /// @param uses  all uses of some edges, in any order; sorted then
  void join(std::span<EdgeUse> uses, bool others);
  bool has_others() const { return has_others_; }

  /// Numbers the shells in the order of their first triangles. Nothing is joined afterwards.
  /// @returns how many there are
  std::uint32_t number();

  // After number():

  struct Side {
    std::uint32_t shell = 0;
    bool turned = false;   ///< relative to the shell's first triangle
    bool dropped = false;  ///< it is there already, or cancels another
    bool even = false;     ///< there is an even number of it: its direction means nothing
  };
  Side of(std::size_t triangle) const;
  /// Drops faces of an even number where the rest of their shell is closed without them.
  /// @param balance  room for as many numbers as there are shells
  void drop_cancelled(std::span<std::int32_t> balance);
  std::size_t size() const { return links_.size(); }

 private:
  /// Bits of marks_.
  enum Mark : std::uint8_t { kCopy = 1, kEven = 2, kNeeded = 4, kNotNeeded = 8, kCancelled = 16 };
  struct Root {
    std::uint32_t triangle = 0;
    std::uint32_t turned = 0;  ///< 0 or 1
  };

  Root find(std::uint32_t triangle);
  void link(std::uint32_t a, std::uint32_t b, std::uint32_t turned);
  void join_edge(std::span<const EdgeUse> uses, bool others);
  void join_rest(std::span<const std::uint32_t> singles);

  std::span<std::uint32_t>
      links_;  ///< twice the parent's number, and 1 if it is turned relative to that; later the shell's
  std::span<std::uint8_t> marks_;
  bool has_others_ = false;
};

/// Two bits for each triangle: what is done with it whenever the mesh is read from now on.
class TriangleSides {
 public:
  static std::size_t bytes_needed(std::uint64_t triangles) { return Arena::rounded(words(triangles) * 8); }
  TriangleSides() = default;
  bool empty() const { return words_.empty(); }  ///< whether all triangles stay as they are
  /// @param arena  bytes_needed() from the top
  [[nodiscard]] static Expected<TriangleSides> create(std::uint64_t triangles, Arena& arena);

  void set(std::size_t triangle, bool turned, bool dropped) {
    words_[triangle / 32] |= std::uint64_t{(turned ? 1U : 0U) | (dropped ? 2U : 0U)} << (2 * (triangle % 32));
  }
  /// Turns a triangle over if need be.
  /// @returns false if it is left out
  template <class AnyTriangle>
  [[nodiscard]] bool apply(std::size_t number, AnyTriangle& triangle) const {
    if (words_.empty()) return true;
    const std::uint64_t bits = words_[number / 32] >> (2 * (number % 32));
    if ((bits & 1U) != 0) std::swap(triangle[1], triangle[2]);
    return (bits & 2U) == 0;
  }

 private:
  static std::size_t words(std::uint64_t triangles) { return static_cast<std::size_t>((triangles + 31) / 32); }
  std::span<std::uint64_t> words_;  ///< empty: nothing is done
};

/// Whether shells may have to be turned over, or hits cancel that should not: some places are wound around the other way than others, or
/// many hits meet another of the opposite direction in the same layer.
[[nodiscard]] bool has_doubtful_sides(const HitList& hits);

/// Decides for each shell which way it faces, by the hits of all rays.
///
/// A shell faces the way that most of its faces had. One that lies inside of no other must face outwards, and is turned over with all that it
/// holds if it does not: so overlapping bodies are one solid, and hollows stay hollows. What lies in a hollow is treated alike. Where the faces of a
/// shell had no side that prevails, it is a hollow if it lies in a solid.
/// @param hits    whose bodies are shells; sorted
/// @param shells  edges, votes, hits and body are set; the rest is set here
/// @param order   room for as many numbers as there are shells
void orient_shells(const HitList& hits, std::span<Shell> shells, std::span<std::uint32_t> order);

}  // namespace plumbline::inline slicer
