#pragma once

#include "firmware/print/store/job_store.hpp"
#include "firmware/print/store/plate_record.hpp"
#include "slicer/core/error.hpp"

namespace plumbline {

/// Whether a print is stored that has begun; then the plate is taken. One that has not is removed: the power went before its checks
/// had passed, so nothing of it is on the plate.
/// @retval the errors of JobStore::end() and PlateRecord::take()
[[nodiscard]] Expected<bool> has_interrupted_print(JobStore& store, PlateRecord& plate);

}  // namespace plumbline
