#include "slicer/plan/scan_admission.hpp"

#include <algorithm>

namespace plumbline {

Expected<ScanAdmission> ScanAdmission::create(std::size_t budget, const std::optional<PrintGrid>& grid,
                                              std::uint32_t threads, bool confidence) {
  PLUMBLINE_TRY(largest_plan(budget, std::nullopt, grid, threads, {.confidence = confidence}));
  ScanAdmission admission;
  admission.budget_ = budget;
  admission.grid_ = grid;
  admission.threads_ = threads;
  admission.evidence_.confidence = confidence;
  return admission;
}

Expected<std::uint32_t> ScanAdmission::admit(const ScanAnnouncement& announced) {
  evidence_.reader_bytes = announced.reader_bytes;
  evidence_.kept_bytes = announced.kept_bytes;
  evidence_.arena_bytes = budget_;
  const auto largest = largest_plan(budget_, std::nullopt, grid_, threads_, evidence_);
  PLUMBLINE_TRY(largest);
  room_ = largest->points;
  const auto capacity = static_cast<std::uint32_t>(
      std::clamp<std::uint64_t>(announced.points.value_or(kMostPoints), kFewestPoints, room_));
  plan_ = plan_memory(capacity, grid_, threads_, evidence_);
  return capacity;
}

MemoryPlan ScanAdmission::plan_for(std::uint32_t points) const {
  constexpr auto kRead = static_cast<std::size_t>(Stage::kRead);
  MemoryPlan plan = plan_memory(points, grid_, threads_, evidence_);
  plan.bytes[kRead] = plan_.bytes[kRead];
  return plan;
}

}  // namespace plumbline
