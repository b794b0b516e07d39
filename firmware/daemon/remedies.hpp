#pragma once

#include <span>

#include "firmware/settings/job_settings.hpp"
#include "firmware/state/printer_record.hpp"
#include "slicer/checks/stack_findings.hpp"
#include "slicer/core/print_grid.hpp"
#include "slicer/core/words/told.hpp"

namespace plumbline::firmware {

/// What a person may press to mend what was found: settings of the job, each of which slices it anew.
/// @param job           as it was sliced
/// @param has_supports  it was given supports where it needs them
/// @returns none where nothing but other hardware, another scan or a person's judgement helps
Remedies remedies_of(const Told& finding, const JobSettings& job, bool has_supports);

/// Where issues of a kind are, the largest first.
IssuePlaces places_of(IssueKind kind, const StackFindings& findings, const PrintGrid& grid);

}  // namespace plumbline::firmware
