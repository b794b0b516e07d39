#pragma once
/// A print from the checks to the raised part, on the devices of a Machine:
///
///     checks -> home -> [ lower -> rest -> ( show mask -> expose ) for each exposure -> blank -> journal -> rest -> lift ] for each layer
///     -> raise
///
/// The next mask, of the layer's next exposure (LayerExposures) or of layer k + 1, is rendered while layer k cures. Whatever ends an exposure,
/// the lamp is dark before anything moves or the mask changes. An exposure that was interrupted goes on where it stopped.

#include <optional>
#include <span>

#include "firmware/print/job/journal.hpp"
#include "firmware/print/job/machine_record.hpp"
#include "firmware/print/job/mask_renderer.hpp"
#include "firmware/print/loop/print_settings.hpp"
#include "firmware/print/status/print_observer.hpp"
#include "firmware/print/status/print_report.hpp"
#include "hal/machine.hpp"

namespace plumbline::firmware {

/// Prints until a state at rest. Errors become the report's fault. Takes nothing from the heap.
/// @param machine    all devices
/// @param masks      of the plan's layers
/// @param journal    null: none is kept, and a power cut ends the print for good
/// @param record     has the resin in the tank; its plate is taken when the checks have passed
/// @param exposures  room for the report's exposures; those beyond it are only counted
/// @param from       the journal's last entry, after an interruption. If the stage is not found where it says, the print asks the user to
///                   measure the part before it lowers the plate. None: a new print
PrintReport run_print(Machine& machine, const PrintSettings& settings, MaskRenderer& masks, Journal* journal,
                      MachineRecord& record, std::span<ExposureLine> exposures, PrintObserver& observer,
                      const std::optional<JournalEntry>& from);

}  // namespace plumbline::firmware
