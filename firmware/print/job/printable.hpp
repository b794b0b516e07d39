#pragma once
/// What is printed, made from a scan or an archive that has been sliced.

#include <cstdint>
#include <optional>
#include <string_view>

#include "firmware/io/descriptor.hpp"
#include "firmware/print/job/contract.hpp"
#include "firmware/print/job/job_file.hpp"
#include "firmware/print/job/sliced_archive.hpp"
#include "firmware/print/job/sliced_scan.hpp"
#include "slicer/checks/stack_findings.hpp"
#include "slicer/slicer.hpp"

namespace plumbline::firmware {

struct Printable {
  JobFacts facts;
  MaskParts parts;     ///< at the bottom of an arena
  Descriptor archive;  ///< of an archive's print
  std::optional<StackFindings>
      findings;  ///< of the masks; none for a print from its store, which was checked when it began
  std::uint64_t first_layer_pixels = 0;
  // Only of a scan that this process has sliced:
  SliceReport slice;
  std::optional<SupportSettings> support_settings;
  SupportCounts support_counts;
  std::uint64_t support_pixels = 0;  ///< that they add
};

/// @param settings  that it was sliced with
/// @retval the errors of plan_print()
[[nodiscard]] Expected<Contract> contract_of(const SlicedScan& sliced, const SliceSettings& settings,
                                             const PrintProfile& profile, const MachineFile& machine);

/// @param profile  profile_of() the archive
/// @retval the errors of plan_print()
[[nodiscard]] Expected<Contract> contract_of(const SlicedArchive& sliced, const PrintProfile& profile,
                                             const MachineFile& machine);

/// @param name      of the scan, for people
/// @param profile   its name
/// @param contract  of it: what somebody has seen
Printable printable_of(const SlicedScan& sliced, std::string_view name, std::string_view profile,
                       const Contract& contract);

/// @param file  the archive; for a session with a store, the copy that JobStore::receive() has made
/// @param hash  of its bytes
Printable printable_of(const SlicedArchive& sliced, std::string_view name, std::string_view profile,
                       const Contract& contract, Descriptor file, std::uint64_t hash);

/// Slices a scan, which is not needed afterwards.
/// @param settings  supports: valid by check_support_settings()
/// @retval any error of slice(), find_supports() and plan_print()
/// @retval ErrorCode::kBadSetting  the profile refuses what the checks of the masks have found, or asks about it
/// @retval ErrorCode::kCancelled
[[nodiscard]] Expected<Printable> slice_printable(ScanSources scan, const SliceSettings& settings,
                                                  const PrintProfile& profile, const MachineFile& machine, Arena& arena,
                                                  ProgressSink* progress);

}  // namespace plumbline::firmware
