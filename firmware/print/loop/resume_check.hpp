#pragma once
/// Whether the stage agrees with the journal of an interrupted print.
///
/// Storage that loses its last writes without a word leaves a journal that looks whole. Resuming from it would press the part into the
/// film. But the power leaves the stage where it was, and a layer can't be cured with the plate lower than the layer's height.

#include <optional>

#include "firmware/print/job/journal.hpp"
#include "firmware/print/job/print_plan.hpp"
#include "firmware/print/status/print_observer.hpp"
#include "hal/units.hpp"

namespace plumbline::firmware {

/// @param last   of the journal
/// @param found  where the stage stood before it was homed; nothing: not known
/// @param drift  ZStage::Limits::drift
/// @returns true if no layer after last.next_layer can have been cured, or if the stage stood where the journal says that a pause or a
///          shutdown has left it. False also if the stage was on its way, which proves nothing
bool stage_confirms(const JournalEntry& last, const PrintPlan& plan, std::optional<ZPosition> found, Distance drift);

/// What was found instead, for the checks.
Spoken doubt_about(const JournalEntry& last, std::optional<ZPosition> found);
/// What the user must measure and answer by start or cancel.
Spoken question_about(const JournalEntry& last);

}  // namespace plumbline::firmware
