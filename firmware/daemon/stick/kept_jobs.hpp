#pragma once
/// What people have set for the scans of a stick, and for the uploaded one, so that nobody has to set it twice.

#include <cstddef>
#include <vector>

#include "firmware/daemon/stick/stick_job.hpp"
#include "firmware/daemon/stick/stick_scans.hpp"

namespace plumbline::firmware {

/// Jobs by their scan: the names of its files, their size and date. A job that nobody has changed takes no room.
class KeptJobs {
 public:
  static constexpr std::size_t kMost = 32;  ///< the one that was changed longest ago goes first

  KeptJobs() { kept_.reserve(kMost); }

  /// Takes a scan at hand.
  /// @param scan      as listed; of a job file only the names
  /// @param uploaded  it is not on the stick
  /// @param plain     its job before anybody has changed it
  /// @returns its job with what was set
  const StickJob& take(const StickEntry& scan, bool uploaded, const StickJob& plain);
  /// Whether a scan is the one that was taken last, and its stick has not left since, or its job has been kept after that.
  bool at_hand(const StickEntry& scan, bool uploaded) const { return is_there_ && Scan{scan, uploaded} == scan_; }
  /// The job of the scan at hand before anybody has changed it.
  const StickJob& plain() const { return plain_; }
  /// Keeps a job of the scan at hand.
  void keep(const StickJob& job);
  /// The stick has left, or the uploaded scan is gone.
  void forget(bool uploaded);

 private:
  struct Scan {
    StickEntry entry;
    bool uploaded = false;
    bool operator==(const Scan&) const = default;
  };
  struct Kept {
    Scan scan;
    StickJob job;
  };
  std::vector<Kept> kept_;  ///< the newest last
  Scan scan_;               ///< at hand
  StickJob plain_;
  StickJob filed_;  ///< the last one of a job file: if it is another, the stick may have been swapped unseen
  bool is_there_ = false;
};

}  // namespace plumbline::firmware
