#pragma once
/// A scan read into a cloud that the memory plan has made room for, as slice() reads it.

#include "slicer/plan/scan_admission.hpp"
#include "tests/slicer/support/scan_cloud.hpp"

namespace plumbline::testing {

struct AdmittedCloud {
  MemoryPlan plan;
  std::uint32_t room = 0;
  CloudReading reading;
};

inline Expected<AdmittedCloud> read_admitted(ScanSources sources, Arena& arena,
                                             const std::optional<PrintGrid>& grid = std::nullopt) {
  auto admission = ScanAdmission::create(arena.available(), grid, 1, false);
  PLUMBLINE_TRY(admission);
  const auto admit = [&](const ScanAnnouncement& announced) { return admission->admit(announced); };
  const auto reading = read_cloud(sources, {}, admit, arena, nullptr);
  PLUMBLINE_TRY(reading);
  return AdmittedCloud{admission->plan(), admission->room(), *reading};
}
inline Expected<AdmittedCloud> read_admitted(ByteSource& source, Arena& arena,
                                             const std::optional<PrintGrid>& grid = std::nullopt) {
  ByteSource* const one[] = {&source};
  return read_admitted(ScanSources(one), arena, grid);
}

}  // namespace plumbline::testing
