#pragma once
/// Has a stick's files read by the slicing child, and keeps the printer's buttons working meanwhile.

#include <chrono>
#include <span>

#include "firmware/child/answer_check.hpp"
#include "firmware/child/slicing_child.hpp"
#include "firmware/daemon/stick/scan_feed.hpp"
#include "firmware/daemon/stick/stick_task.hpp"
#include "firmware/print/job/job_store.hpp"
#include "hal/machine.hpp"
#include "slicer/core/arena.hpp"

namespace plumbline::firmware {

/// A child that shows no sign of life for this long is killed, and so is one whose progress has not risen for ten times as long. A child
/// that works is silent for 8 s at most, while it builds a tree of 1,000,000 points on a Cortex-A53. A stick that does not answer delays
/// a read by the kernel's 30 s, perhaps twice.
inline constexpr std::chrono::seconds kSlicingPatience{120};

/// Follows the slicing.
class SlicingObserver {
 public:
  virtual ~SlicingObserver() = default;
  /// Called several times a second.
  /// @param fraction  of the stage, 0 to 1
  virtual void slicing(Stage stage, double fraction) = 0;
};

class ScanSlicing {
 public:
  /// @param arena     over the child's arena_block(), empty
  /// @param patience  kSlicingPatience; shorter in tests
  ScanSlicing(SlicingChild& child, Machine& machine, Arena& arena, SlicingObserver& observer,
              std::chrono::nanoseconds patience)
      : child_(child), machine_(machine), arena_(arena), observer_(observer), patience_(patience) {}

  /// @param scan  the request's files, open
  /// @returns what the child found, checked, at the bottom of the arena
  /// @retval the errors of check_answer()
  /// @retval ErrorCode::kMalformed      the child crashed or hung
  /// @retval ErrorCode::kCancelled      cancel was pressed, or the system shuts down: see shutdown()
  /// @retval ErrorCode::kStickGone      the stick was pulled before all was read
  /// @retval ErrorCode::kCannotRead     bad sectors
  /// @retval ErrorCode::kDeviceTimeout  no child can be started any more
  /// @retval ErrorCode::kPowerLost
  [[nodiscard]] Expected<CheckedAnswer> run(const StickMount& mount, std::span<StickFile> scan,
                                            const ScanRequest& request);

  /// Has the best ways up of a scan found by a child.
  /// @param scan  the request's files, open; the request proposes
  /// @retval the errors of check_proposals(), and those of run()
  [[nodiscard]] Expected<Proposals> propose(const StickMount& mount, std::span<StickFile> scan,
                                            const ScanRequest& request);

  /// What may end the work on a stick: for whoever reads it here.
  /// @retval ErrorCode::kCancelled  cancel was pressed, or the system shuts down: see shutdown()
  /// @retval the errors of StickMount::check()
  [[nodiscard]] Status look(const StickMount& mount);

  /// Has a job file read by a child.
  /// @retval the errors of check_job_answer(), and those of run()
  [[nodiscard]] Expected<StickJob> read_job(const StickMount& mount, StickFile& file);

  /// Copies an archive from a stick into the store.
  /// @retval the errors of JobStore::receive(); kCancelled and kStickGone as of run()
  [[nodiscard]] Expected<JobStore::Received> copy(const StickMount& mount, StickFile& archive, JobStore& store);
  /// Lets a child check an archive.
  /// @param file  its descriptor
  /// @returns what the child found, checked; its layers are at the bottom of the arena
  /// @retval the errors of check_archive_answer(), and those of run() but of a stick
  [[nodiscard]] Expected<SlicedArchive> check(int file, const ScanRequest& request);

  /// Kills a child that somebody else has started, and waits for its end: see kill_and_wait().
  void end_child() { static_cast<void>(kill_and_wait()); }

  bool shutdown() const { return shutdown_; }  ///< whether the system asked to end

 private:
  using HostClock = std::chrono::steady_clock;

  [[nodiscard]] Expected<ScanAnswer> work(const StickMount& mount, std::span<StickFile> files,
                                          const ScanRequest& request);
  [[nodiscard]] Expected<ScanAnswer> follow(const StickMount* mount, ScanFeed* feed, const ScanRequest& request);
  Error child_said(const ScanAnswer& answer, const Error& error, const StickMount& mount, const ScanRequest& request);
  Status watch(const StickMount* mount, const ScanRequest& request, bool fed);
  Status look_at_buttons();
  [[nodiscard]] Expected<int> kill_and_wait();
  Error pulled_or_bad(const StickMount& mount, const Error& error);

  SlicingChild& child_;
  Machine& machine_;
  Arena& arena_;
  SlicingObserver& observer_;
  std::chrono::nanoseconds patience_;
  bool shutdown_ = false;
  std::uint32_t beats_ = 0;          ///< ChildProgress::beats when it last changed,
  HostClock::time_point beaten_at_;  ///< which was then
  std::uint32_t reached_ = 0;        ///< the farthest stage and fraction that the child has reported,
  HostClock::time_point risen_at_;   ///< which was then
};

}  // namespace plumbline::firmware
