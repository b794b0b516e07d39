#pragma once
/// What each place of the surface rests on: the scan, or what was added where the scan had nothing.

#include <array>
#include <cstddef>
#include <cstdint>
#include <span>

#include "slicer/core/arena.hpp"
#include "slicer/core/error.hpp"
#include "slicer/core/numbers/vec.hpp"
#include "slicer/core/print_grid.hpp"

namespace plumbline::inline slicer {

/// What a crossing rests on.
enum class Evidence : std::uint8_t {
  kMeasured,  ///< an intersection with the surface of the points
  kWinding,   ///< the winding number of the cloud: the scan has nothing there or contradicts itself
  kBase,      ///< the base plane under an open underside
};
inline constexpr std::size_t kEvidenceCount = 3;

/// "measured", "winding number", "base plane".
const char* to_string(Evidence evidence);

/// Totals over all layers and the whole surface, by Evidence.
struct ConfidenceShares {
  std::array<std::uint64_t, kEvidenceCount> crossings = {};
  std::array<double, kEvidenceCount> surface = {};  ///< 0 to 1

  double of(Evidence evidence) const { return surface[static_cast<std::size_t>(evidence)]; }
};

/// Counts of crossings by layer, and a coarse map of what each cell of the surface rests on. The memory is the arena's; its
/// size depends on the number of layers alone. Many threads may write; the result does not depend on their order.
class ConfidenceMap {
 public:
  static constexpr std::size_t kMostCells = std::size_t{1} << 19U;  ///< about 80 a side, one byte each, half a MiB

  using Counts = std::array<std::uint32_t, kEvidenceCount>;  ///< crossings, by Evidence

  /// Bytes of arena that create() takes.
  static std::size_t bytes_needed(std::uint32_t layers);
  /// @param box         of the placed points, mm
  /// @param least_cell  smallest side of a cell, mm, so large that nearly every cell on the surface holds a point
  /// @param arena       bytes_needed() from the bottom
  /// @retval ErrorCode::kOutOfMemory
  [[nodiscard]] static Expected<ConfidenceMap> create(const PrintGrid& grid, const Box3f& box, float least_cell,
                                                      Arena& arena);

  /// Whether there is no map.
  bool empty() const { return cells_.empty(); }

  /// Adds a crossing. Thread-safe.
  void add(std::uint32_t column, std::uint32_t row, std::uint32_t layer, Evidence evidence);
  /// Adds a point of the scan, mm. Not thread-safe.
  void add_point(const Vec3f& p);
  /// Puts layers without crossings below; a longer list of layers is taken from the bottom of the arena.
  /// @retval ErrorCode::kOutOfMemory  the map is unchanged
  [[nodiscard]] Status raise(std::uint32_t layers, Arena& arena);
  /// Removes layers at both ends. At least one must be left.
  void trim(std::uint32_t below, std::uint32_t above);

  /// Crossings of each layer as shot, before small components and small features were removed.
  std::span<const Counts> layers() const { return layers_; }
  std::array<std::uint64_t, kEvidenceCount> crossings() const;

  /// Share of the surface, by Evidence, 0 to 1. Areas are counted in cells; a cell is measured if it or a neighbour was. The
  /// area of the base plane is counted in rays.
  std::array<double, kEvidenceCount> surface() const;
  ConfidenceShares shares() const { return {crossings(), surface()}; }
  /// What the surface at a voxel rests on; kWinding if neither a point nor a crossing is near.
  Evidence at(std::uint32_t column, std::uint32_t row, std::uint32_t layer) const;

 private:
  using Cell = Eigen::Array<std::int64_t, 3, 1>;
  Cell cell_of(const Vec3f& p) const;
  Evidence evidence_at(const Cell& cell) const;
  Vec3f middle_of(std::uint32_t column, std::uint32_t row, std::uint32_t layer) const;
  std::size_t index(const Cell& cell) const {
    return static_cast<std::size_t>((cell[2] * dims_[1] + cell[1]) * dims_[0] + cell[0]);
  }

  PrintGrid grid_;
  std::span<Counts> layers_;
  std::span<std::uint8_t> cells_;  ///< one bit for each Evidence found there
  Vec3f low_ = Vec3f::Zero();      ///< mm
  float inverse_ = 0;              ///< cells per mm
  Cell dims_ = Cell::Zero();
};

}  // namespace plumbline::inline slicer
