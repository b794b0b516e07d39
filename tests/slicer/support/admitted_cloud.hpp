#pragma once
/// A scan read into a cloud that the memory plan has made room for, as slice() reads it.

#include "slicer/cloud/cloud_reader.hpp"
#include "slicer/plan/memory_plan.hpp"
#include "tests/slicer/support/scan_cloud.hpp"

namespace plumbline::testing {

struct AdmittedCloud {
  MemoryPlan plan;
  CloudReading reading;
};

inline Expected<AdmittedCloud> read_admitted(ScanSources sources, Arena& arena,
                                             const std::optional<PrintGrid>& grid = std::nullopt) {
  const std::size_t budget = arena.available();
  MemoryPlan plan;
  const auto admit = [&](const ScanAnnouncement& announced) -> Expected<std::uint32_t> {
    const PlanEvidence evidence{.reader_bytes = announced.reader_bytes, .kept_bytes = announced.kept_bytes};
    const auto admitted = largest_plan(budget, announced.points, grid, 1, evidence);
    PLUMBLINE_TRY(admitted);
    plan = *admitted;
    return plan.points;
  };
  const auto reading = read_cloud(sources, {}, admit, arena, nullptr);
  PLUMBLINE_TRY(reading);
  return AdmittedCloud{plan, *reading};
}
inline Expected<AdmittedCloud> read_admitted(ByteSource& source, Arena& arena,
                                             const std::optional<PrintGrid>& grid = std::nullopt) {
  ByteSource* const one[] = {&source};
  return read_admitted(ScanSources(one), arena, grid);
}

}  // namespace plumbline::testing
