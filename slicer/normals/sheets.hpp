#pragma once
/// Sheets of a surface, and which side of each is the outer one.

#include <cstdint>
#include <span>

#include "slicer/cloud/cloud.hpp"
#include "slicer/core/arena.hpp"
#include "slicer/core/error.hpp"
#include "slicer/core/function_ref.hpp"
#include "slicer/implicit/dipole_field.hpp"
#include "slicer/normals/normal_counts.hpp"
#include "slicer/normals/sided_sets.hpp"

namespace plumbline::inline slicer {

/// A set of connected points whose sides are known relative to each other.
struct NormalSheet {
  std::uint32_t root = 0;
  std::uint32_t points = 0;
  std::int32_t votes = 0;     ///< known normals that agree, minus those that do not
  std::uint32_t samples = 0;  ///< points where the field was evaluated
  std::int64_t winding = 0;   ///< sum of W over the samples, times 2^20
  std::int64_t slope = 0;     ///< sum of -<n, grad W> times the size of the sheet, times 2^20
  double area = 0;            ///< mm^2
  Vec3d centroid = Vec3d::Zero();
  double flux = 0;   ///< sum of a <n, p - c>
  double reach = 0;  ///< sum of a |p - c|: the most that the flux can be
  float side = 0;    ///< 1 or -1; 0 until it is known
  /// Neighbours in other sheets that face the other side, minus those that face the same side.
  std::int32_t contradictions = 0;
};

/// How surely two neighbours lie on one sheet, and whether they face the same side. The chord d between them lies nearly in
/// the surface, so the normals' components along it come from the surface's bending. Only the rest tells the side:
///
///   w(i, j) = <n_i, n_j> - <n_i, d> <n_j, d> / <d, d>
///
/// @returns -1 to 1, negative if they face opposite sides. The magnitude is the confidence: 1 on a plane; 1/2 across a right
///          edge, where the inner product would be 0; 0 through a thin wall, where the inner product would be -1
float join_weight(const Cloud& cloud, std::uint32_t i, std::uint32_t j);

/// How the side of the first sheet is chosen, before there is a field.
enum class FirstSide : std::uint8_t {
  kKnownOrConvex,  ///< by votes of the fixed members; without any, the convex side of the largest sheet is the outer one
  kLargest,        ///< the largest sheet is right, unless it is inside out; by votes if there are fixed members
};

/// The sheets of joined points, the largest first. The area of point i is pi radius[i]^2.
class Sheets {
 public:
  using Stays = FunctionRef<bool(std::uint32_t)>;

  /// Most bytes of arena that turn() takes, not counting the rounding of blocks.
  static std::size_t bytes_needed(std::uint32_t points);

  /// @param sets  one a sheet; the normals of fixed members are right and never turned over
  Sheets(Cloud& cloud, SidedSets& sets, Arena& arena) : cloud_(cloud), sets_(sets), arena_(arena) {}

  /// Turns every normal that is not fixed to the outer side, by rule 2 of orient_normals().
  /// @param stays  of a single point that the field hardly contradicts: whether other evidence says that it is right
  /// @returns normals turned over, and whether the largest sheet had to be, too
  /// @retval ErrorCode::kOutOfMemory
  [[nodiscard]] Expected<NormalCounts> turn(
      FirstSide first, Stays stays = [](std::uint32_t) { return false; });

  /// Limits radii to a few times their median. An outlier has as much room around it as a thousand points of the surface
  /// and must not count as much.
  /// @returns the median, mm
  [[nodiscard]] static Expected<float> limit_areas(Cloud& cloud, Arena& arena);

 private:
  Status list();
  NormalSheet* sheet_of(std::uint32_t i) const;
  double area(std::uint32_t i) const;
  void measure();
  void count_contradictions();
  float side(std::uint32_t i) const;
  auto sides() const {
    return [this](std::uint32_t i) { return side(i); };
  }
  void find_sides(DipoleField& field, FirstSide rule);
  void find_other_sides(DipoleField& field);
  void find_sides_by_field(const DipoleField& field, std::span<NormalSheet> sheets);
  void sample(const DipoleField& field, std::span<NormalSheet> sheets, std::uint32_t most);
  bool first_is_inside_out(const DipoleField& field);
  bool is_height_field() const;
  void turn_loose_points(const DipoleField& field, Stays stays);
  double total_flux() const;

  Cloud& cloud_;
  SidedSets& sets_;
  Arena& arena_;
  std::span<NormalSheet> sheets_;
  NormalCounts counts_;
  bool any_known_ = false;                ///< a normal is fixed
  FirstSide rule_ = FirstSide::kLargest;  ///< kLargest: the normals are those of the scan
};

}  // namespace plumbline::inline slicer
