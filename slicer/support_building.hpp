#pragma once
/// Adds supports to a sliced scan.

#include "slicer/checks/stack_findings.hpp"
#include "slicer/core/arena.hpp"
#include "slicer/core/progress.hpp"
#include "slicer/rrep/rrep.hpp"
#include "slicer/slice_report.hpp"
#include "slicer/slice_settings.hpp"
#include "slicer/supports/support_finder.hpp"

namespace plumbline::inline slicer {

/// find_supports() for what slice() returned, if the settings ask for supports, and correct_bleed(), if they know how light cures. The report
/// follows the object when it is lifted or sinks.
/// @param settings  that it was sliced with: the printer's travel is the limit
/// @param report    of slice()
/// @retval all errors of find_supports() and correct_bleed()
[[nodiscard]] Expected<Supports> add_supports(RRep& rrep, const SliceSettings& settings, Arena& arena,
                                              ProgressSink* progress, SliceReport& report, SupportCounts& counts);

/// Adds the largest place of those that no support reaches to what the checks of the print's masks have found, and finds what matters.
void finish_findings(StackFindings& findings, const Supports& supports, const SupportCounts& counts,
                     const SliceReport& report);

/// Room that supports need round the object: heads, bases and raft beside it, and the lift below.
PlacementRoom support_room(const SupportSettings& settings);

}  // namespace plumbline::inline slicer
