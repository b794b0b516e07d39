#include "firmware/daemon/scan_glances.hpp"

#include <utility>

#include "firmware/archive/layer_archive.hpp"

namespace plumbline::firmware {

bool ScanGlances::step() {
  while (!works_) {
    if (next_ >= record_.scan_count || record_.has_job_file || child_.gone()) return false;
    works_ = begin(next_);
    if (!works_) ++next_;
  }
  // A simulated stick hands its bytes on through a pipe. Never spend long on it, since the daemon has other work.
  const auto until = HostClock::now() + std::chrono::milliseconds(2);
  bool pumps = true;
  while (pumps && HostClock::now() < until) {
    const auto moved = feed_->pump();
    pumps = moved && *moved;
    if (!moved) child_.kill();
  }
  const auto ended = child_.wait(std::chrono::milliseconds(0));
  if (ended && !*ended) {
    const auto patience = settings_.slicing_patience / 2;
    if (HostClock::now() - began_at_ > patience && !std::exchange(killed_, true)) child_.kill();
    return true;
  }
  works_ = false;
  feed_.reset();
  files_.clear();
  // A picture of a child that has crashed may be half of one.
  if (ended && **ended == 0 && child_.answer().kind == ScanAnswer::kGlance) recorder_.glanced(next_, child_.glance());
  ++next_;
  return true;
}

/// @returns whether a child works
bool ScanGlances::begin(std::size_t scan) {
  const ScanRecord& known = record_.scans[scan];
  if (known.picture > 0 || !known.problem.view().empty()) return false;
  StickJob job;
  job.scans = offer_.files_of(scan);
  // Only an archive's directory and its thumbnail or a few layers are read, so its size doesn't matter.
  const bool is_archive = is_archive_name(job.scans[0]);
  if (!is_archive && known.bytes > kMostBytes) return false;
  auto files = open_scan(job, mount_);
  if (!files) return false;
  files_ = std::move(*files);
  ScanRequest request;
  if (is_archive) {
    request.archive.ask = ArchiveRequest::Ask::kGlance;
    request.settings.placement.printer = printer_volume(settings_.board);
  } else {
    request.is_glance = true;
  }
  request.name.add("%s", job.title().c_str());
  for (const StickFile& file : files_) request.add_file(file.name(), file.size());
  request.settings.threads = settings_.threads;
  feed_.emplace(files_);
  const auto descriptors = feed_->open();
  const bool started = descriptors && child_.start(request, *descriptors);
  if (started) feed_->opened();
  killed_ = false;
  began_at_ = HostClock::now();
  return started;
}

void ScanGlances::stop() {
  if (!std::exchange(works_, false)) return;
  slicing_.end_child();
  feed_.reset();
  files_.clear();
}

}  // namespace plumbline::firmware
