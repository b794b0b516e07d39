#pragma once
/// What the print rests on, place by place: the scan, or what was put where the scan had nothing.

#include <array>
#include <cstddef>
#include <cstdint>
#include <span>

#include "slicer/core/arena.hpp"
#include "slicer/core/error.hpp"
#include "slicer/core/print_grid.hpp"
#include "slicer/core/vec.hpp"

namespace plumbline {

/// What a crossing rests on.
enum class Evidence : std::uint8_t {
  kMeasured,  ///< an intersection with the surface of the points
  kRepaired,  ///< one that only the uniform queries of a repair found
  /// The winding number of the cloud, or walls of bores that were continued: the scan has nothing there, or it contradicts
  /// itself.
  kWinding,
  kBase,  ///< the base plane under an open underside
};
inline constexpr std::size_t kEvidenceCount = 4;

/// "measured", "repaired", "winding number", "base plane".
const char* to_string(Evidence evidence);

/// All layers and all of the surface in a few numbers, by Evidence.
struct ConfidenceShares {
  std::array<std::uint64_t, kEvidenceCount> crossings = {};
  std::array<double, kEvidenceCount> surface = {};  ///< 0 to 1

  double of(Evidence evidence) const { return surface[static_cast<std::size_t>(evidence)]; }
};

/// Counts by layer, and a coarse map of the surface: what each cell of it rests on. All memory is the arena's, its size fixed
/// by the number of layers. Written by many threads; what is in it does not depend on their order.
class ConfidenceMap {
 public:
  static constexpr std::size_t kMostCells = std::size_t{1} << 19U;  ///< some 80 a side, a byte each

  using Counts = std::array<std::uint32_t, kEvidenceCount>;  ///< crossings, by Evidence

  /// Bytes that create() takes.
  static std::size_t bytes_needed(std::uint32_t layers);
  /// @param box         of the placed points, mm
  /// @param least_cell  mm; a surface has a point in nearly every cell of that side
  /// @param arena       bytes_needed() from the bottom
  /// @retval ErrorCode::kOutOfMemory
  [[nodiscard]] static Expected<ConfidenceMap> create(const PrintGrid& grid, const Box3f& box, float least_cell,
                                                      Arena& arena);

  /// No map was asked for.
  bool empty() const { return cells_.empty(); }

  /// A crossing. From any thread.
  void add(std::uint32_t column, std::uint32_t row, std::uint32_t layer, Evidence evidence);
  /// A point of the scan, mm. From one thread.
  void add_point(const Vec3f& p);
  /// So many layers have gone at either end, fewer than there are.
  void trim(std::uint32_t below, std::uint32_t above);

  /// Crossings of each layer, as they were shot: before specks and small features were taken out.
  std::span<const Counts> layers() const { return layers_; }
  std::array<std::uint64_t, kEvidenceCount> crossings() const;

  /// Share of the surface, by Evidence. Its area is that of the cells that it passes through, where what was measured, in
  /// the cell or beside it, comes before what was not; that of the base plane is its rays'.
  std::array<double, kEvidenceCount> surface() const;
  ConfidenceShares shares() const { return {crossings(), surface()}; }
  /// What the surface at a voxel rests on. Where neither a point nor a crossing is near it was never seen: kWinding.
  Evidence at(std::uint32_t column, std::uint32_t row, std::uint32_t layer) const;

 private:
  using Cell = std::array<std::int64_t, 3>;
  Cell cell_of(const Vec3f& p) const;
  Evidence evidence_at(const Cell& cell) const;
  Vec3f middle_of(std::uint32_t column, std::uint32_t row, std::uint32_t layer) const;
  std::size_t index(const Cell& cell) const {
    return static_cast<std::size_t>((cell[2] * dims_[1] + cell[1]) * dims_[0] + cell[0]);
  }

  PrintGrid grid_;
  std::span<Counts> layers_;
  std::span<std::uint8_t> cells_;  ///< a bit for each Evidence that was found there
  Vec3f low_ = Vec3f::Zero();      ///< mm
  float inverse_ = 0;              ///< cells a mm
  Cell dims_{};
};

}  // namespace plumbline
