#pragma once

#include "firmware/daemon/daemon_settings.hpp"
#include "firmware/print/sliced_archive.hpp"
#include "firmware/settings/print_profile.hpp"
#include "firmware/state/printer_record.hpp"

namespace plumbline {

/// Goes once over the crossings.
MaskExtent extent_of(const RRep& rrep);

/// What would be printed, for people who decide whether it is.
/// @retval any error of plan_print()
[[nodiscard]] Expected<SlicedRecord> sliced_record(const PrintGrid& grid, const MaskExtent& extent,
                                                   const StackFindings& findings, const PrintProfile& profile,
                                                   const MachineFile& machine);

/// "62.1 x 48.2 x 80.2 mm, 1604 layers, 34.5 ml, 266 min"
FixedText<160> sliced_line(const SlicedRecord& sliced);

}  // namespace plumbline
