#pragma once
/// The contract of what has been sliced, here or by somebody else.

#include "firmware/print/contract/contract.hpp"
#include "firmware/print/sliced_archive.hpp"
#include "firmware/print/sliced_scan.hpp"
#include "slicer/slice_settings.hpp"

namespace plumbline {

/// @param settings  that it was sliced with
/// @retval the errors of plan_print()
[[nodiscard]] Expected<Contract> contract_of(const SlicedScan& sliced, const SliceSettings& settings,
                                             const PrintProfile& profile, const MachineFile& machine);

/// @param profile  profile_of() the archive
/// @retval the errors of plan_print()
[[nodiscard]] Expected<Contract> contract_of(const SlicedArchive& sliced, const PrintProfile& profile,
                                             const MachineFile& machine);

}  // namespace plumbline
