#include "firmware/daemon/stick/kept_jobs.hpp"

#include <algorithm>

namespace plumbline::firmware {

const StickJob& KeptJobs::take(const StickEntry& scan, bool uploaded, const StickJob& plain) {
  plain_ = plain;
  scan_ = {scan, uploaded};
  is_there_ = true;
  const bool is_filed = scan.bytes == 0;
  if (is_filed && plain != filed_) {
    std::erase_if(kept_, [this](const Kept& kept) { return kept.scan == scan_; });
    filed_ = plain;
  }
  const auto kept = std::ranges::find(kept_, scan_, &Kept::scan);
  return kept == kept_.end() ? plain_ : kept->job;
}

void KeptJobs::keep(const StickJob& job) {
  is_there_ = true;
  std::erase_if(kept_, [this](const Kept& kept) { return kept.scan == scan_; });
  if (job == plain_) return;
  if (kept_.size() == kMost) kept_.erase(kept_.begin());
  kept_.push_back({scan_, job});
}

void KeptJobs::forget(bool uploaded) {
  std::erase_if(kept_, [uploaded](const Kept& kept) { return kept.scan.uploaded == uploaded; });
  is_there_ = is_there_ && scan_.uploaded != uploaded;
}

}  // namespace plumbline::firmware
