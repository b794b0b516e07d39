#include "firmware/print/store/interrupted_print.hpp"

namespace plumbline {

Expected<bool> has_interrupted_print(JobStore& store, PlateRecord& plate) {
  if (!store.has_job()) return false;
  const auto progress = store.progress();
  const bool none_cured = progress ? *progress == JournalEntry() : progress.error().code() == ErrorCode::kTruncated;
  if (plate.is_empty() && none_cured) {
    PLUMBLINE_TRY(store.end());
    return false;
  }
  PLUMBLINE_TRY(plate.take());
  return true;
}

}  // namespace plumbline
