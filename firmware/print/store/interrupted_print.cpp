#include "firmware/print/store/interrupted_print.hpp"

namespace plumbline {

Expected<MachineRecord> open_machine_record(const std::string& folder, const JobStore& store, double tank_ml,
                                            bool simulated) {
  auto record = MachineRecord::open(folder, tank_ml);
  PLUMBLINE_TRY(record);
  PLUMBLINE_TRY(record->add_interrupted(store));
  if (simulated && !record->resin_ml() && !store.has_job()) PLUMBLINE_TRY(record->fill(tank_ml));
  return record;
}

Expected<bool> has_interrupted_print(JobStore& store, MachineRecord& machine) {
  if (!store.has_job()) return false;
  const auto progress = store.progress();
  const bool none_cured =
      progress ? progress->last == JournalEntry() : progress.error().code() == ErrorCode::kTruncated;
  if (machine.plate_is_empty() && none_cured) {
    PLUMBLINE_TRY(store.end());
    return false;
  }
  PLUMBLINE_TRY(machine.take_plate());
  return true;
}

}  // namespace plumbline
