#pragma once

#include <string>

#include "firmware/print/store/job_store.hpp"
#include "firmware/print/store/machine_record.hpp"
#include "slicer/core/error.hpp"

namespace plumbline {

/// Opens the printer's record and adds what an interrupted print has used since.
/// @param tank_ml    resin in a full tank
/// @param simulated  its tank is full until something is printed
/// @retval the errors of MachineRecord::open() and add_interrupted()
[[nodiscard]] Expected<MachineRecord> open_machine_record(const std::string& folder, const JobStore& store,
                                                          double tank_ml, bool simulated);

/// Whether a print is stored that has begun; then the plate is taken. One that has not is removed: the power went before its checks
/// had passed, so nothing of it is on the plate.
/// @retval the errors of JobStore::end() and MachineRecord::take_plate()
[[nodiscard]] Expected<bool> has_interrupted_print(JobStore& store, MachineRecord& machine);

}  // namespace plumbline
