#pragma once

#include <chrono>
#include <cstddef>
#include <optional>
#include <vector>

#include "firmware/child/slicing_child.hpp"
#include "firmware/daemon/daemon_settings.hpp"
#include "firmware/daemon/state_recorder.hpp"
#include "firmware/daemon/stick/scan_feed.hpp"
#include "firmware/daemon/stick/scan_slicing.hpp"
#include "firmware/daemon/stick_offer.hpp"
#include "hal/stick_port.hpp"

namespace plumbline::firmware {

/// Draws what is on a stick while somebody chooses: a small picture of each scan and archive, one after the other, each in a child without
/// rights. A child that takes longer than half of DaemonSettings::slicing_patience is killed.
class ScanGlances {
 public:
  /// A scan whose files are larger in all has no picture, since reading it takes too long. An archive may have any size.
  static constexpr std::uint64_t kMostBytes = 256'000'000;

  /// All must outlive it. No other child runs while it works.
  ScanGlances(const StickMount& mount, const StickOffer& offer, const PrinterRecord& record, SlicingChild& child,
              ScanSlicing& slicing, StateRecorder& recorder, const DaemonSettings& settings)
      : mount_(mount),
        offer_(offer),
        record_(record),
        child_(child),
        slicing_(slicing),
        recorder_(recorder),
        settings_(settings) {}
  ~ScanGlances() { stop(); }
  ScanGlances(const ScanGlances&) = delete;
  ScanGlances& operator=(const ScanGlances&) = delete;

  /// Goes on, and never waits for a child.
  /// @returns whether one works
  bool step();
  /// Ends the child, if one works.
  void stop();

 private:
  using HostClock = std::chrono::steady_clock;
  bool begin(std::size_t scan);

  const StickMount& mount_;
  const StickOffer& offer_;
  const PrinterRecord& record_;
  SlicingChild& child_;
  ScanSlicing& slicing_;
  StateRecorder& recorder_;
  const DaemonSettings& settings_;
  std::size_t next_ = 0;  ///< scan to look at, or the one that is looked at
  bool works_ = false;
  bool killed_ = false;
  HostClock::time_point began_at_{};
  std::vector<StickFile> files_;
  std::optional<ScanFeed> feed_;
};

}  // namespace plumbline::firmware
