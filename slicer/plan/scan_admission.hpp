#pragma once
/// Whether a scan fits into the arena, and how many of its points it has room for.

#include "slicer/cloud/cloud_reader.hpp"
#include "slicer/plan/memory_plan.hpp"

namespace plumbline {

/// Admits a scan twice: before its first byte by the printer's grid alone, and before its first point by what the headers
/// of its files announce.
class ScanAdmission {
 public:
  /// @param budget      bytes of the arena that the job may use
  /// @param grid        of the printer; none: the grid is the object's own
  /// @param confidence  SliceSettings::confidence
  /// @retval ErrorCode::kOutOfMemory  not even kFewestPoints fit: need and budget
  [[nodiscard]] static Expected<ScanAdmission> create(std::size_t budget, const std::optional<PrintGrid>& grid,
                                                      std::uint32_t threads, bool confidence);

  /// @returns points to take room for: as many as are announced, at most room(), kFewestPoints at least
  /// @retval ErrorCode::kOutOfMemory  not even kFewestPoints fit beside what the reader keeps
  [[nodiscard]] Expected<std::uint32_t> admit(const ScanAnnouncement& announced);

  std::uint32_t room() const { return room_; }      ///< points that the arena has room for, known after admit()
  const MemoryPlan& plan() const { return plan_; }  ///< for the points admitted, known after admit()
  /// For the points that are left of those admitted, when all have been read: call after admit().
  MemoryPlan plan_for(std::uint32_t points) const;

 private:
  std::size_t budget_ = 0;
  std::optional<PrintGrid> grid_;
  std::uint32_t threads_ = 1;
  PlanEvidence evidence_;
  std::uint32_t room_ = 0;
  MemoryPlan plan_;
};

}  // namespace plumbline
