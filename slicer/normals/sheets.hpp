#pragma once
/// Parts of the surface whose points know their sides relative to each other, and which side of each is the outer one.

#include <cstdint>
#include <span>

#include "slicer/cloud/cloud.hpp"
#include "slicer/core/arena.hpp"
#include "slicer/core/error.hpp"
#include "slicer/implicit/dipole_field.hpp"
#include "slicer/normals/sided_sets.hpp"

namespace plumbline {

/// A set of points whose sides are known relative to each other.
struct Sheet {
  std::uint32_t root = 0;
  std::uint32_t points = 0;
  std::int32_t votes = 0;     ///< known normals that agree less those that do not
  std::uint32_t samples = 0;  ///< points where the field was asked
  std::int64_t winding = 0;   ///< sum of W over the samples, in units of Sheets
  std::int64_t slope = 0;     ///< sum of -<n, grad W> times the size of the sheet, in the same
  double area = 0;            ///< mm^2
  Vec3d centroid = Vec3d::Zero();
  double flux = 0;   ///< sum of a <n, p - c>
  double reach = 0;  ///< sum of a |p - c|: the most that the flux can be
  float side = 0;    ///< 1 or -1 once it is known
};

/// How surely two neighbours lie on one sheet, and which way round. The chord d from one to the other lies nearly in the
/// surface, so that the normals' parts along it tell how the surface bends and only the rest tells the side:
///
///   w(i, j) = <n_i, n_j> - <n_i, d> <n_j, d> / <d, d>
///
/// @returns -1 to 1; negative: they face opposite sides. The magnitude is the confidence: 1 on a plane, 1/2 across a right
///          edge, where the inner product alone says nothing, 0 through a thin wall, where it alone says the wrong thing
float join_weight(const Cloud& cloud, std::uint32_t i, std::uint32_t j);

/// What the first side is taken from, before any field can be asked.
enum class FirstSide : std::uint8_t {
  kKnownOrConvex,  ///< the fixed members' votes; where nobody is fixed, the convex side of the largest sheet
  kLargest,        ///< the largest sheet is right as it is
};

/// The sheets that joined points make, the largest first. radius[i]^2 pi of the cloud is the area of point i.
class Sheets {
 public:
  /// Bytes of arena that turn() takes at most, rounding of blocks apart.
  static std::size_t bytes_needed(std::uint32_t points);

  /// @param sets  joined; the fixed members' normals are right and are never turned
  Sheets(Cloud& cloud, SidedSets& sets, Arena& arena) : cloud_(cloud), sets_(sets), arena_(arena) {}

  /// Turns every normal that is not fixed to the outer side, as orient_normals() says under 2.
  /// @returns normals that face the other way now
  /// @retval ErrorCode::kOutOfMemory
  [[nodiscard]] Expected<std::uint32_t> turn(FirstSide first);

  /// Cuts radii to a few times their median: a stray point has as much room round it as a thousand points of the surface
  /// and must not speak for as many.
  [[nodiscard]] static Status limit_areas(Cloud& cloud, Arena& arena);

 private:
  Status list();
  Sheet* sheet_of(std::uint32_t i) const;
  double area(std::uint32_t i) const;
  void measure();
  void turn_normal(std::uint32_t i);
  float side(std::uint32_t i) const;
  void find_sides(DipoleField& field, FirstSide rule);
  void ask_field(const DipoleField& field, std::uint32_t first, std::uint32_t last);
  void turn_loose_points(DipoleField& field);
  double total_flux() const;

  Cloud& cloud_;
  SidedSets& sets_;
  Arena& arena_;
  std::span<Sheet> sheets_;
  std::uint32_t turned_ = 0;  ///< normals
};

}  // namespace plumbline
