#pragma once
/// The firmware's side of the slicing child, which reads and slices a scan without the right to do anything else.

#include <sys/types.h>

#include <chrono>
#include <memory>
#include <optional>
#include <span>

#include "firmware/child/child_template.hpp"
#include "firmware/child/scan_task.hpp"
#include "firmware/child/shared_memory.hpp"
#include "firmware/io/descriptor.hpp"
#include "slicer/core/error.hpp"

namespace plumbline::firmware {

class SlicingChild {
 public:
  /// Makes the shared memory and the template process. Call it before anything is opened and before any thread is started: the template
  /// inherits both.
  /// @param threads  of a child
  /// @param task     what a child does
  /// @retval ErrorCode::kOutOfMemory  no memory
  /// @retval ErrorCode::kUnsupported  the process can't be made, or the kernel lacks what keeps it apart
  [[nodiscard]] static Expected<SlicingChild> make(std::size_t arena_bytes, std::uint32_t threads,
                                                   ChildTask task = run_scan_task);
  SlicingChild(SlicingChild&& other) noexcept;
  SlicingChild& operator=(SlicingChild&&) = delete;
  /// Ends the template and its child, within some seconds also if the template is stopped.
  ~SlicingChild();

  /// A template that has not reported a killed child's end for this long is killed itself. The child may be waiting for a stick that does
  /// not answer: the kernel gives up after 30 s, perhaps twice.
  static constexpr std::chrono::seconds kEndPatience{90};

  /// The memory that a child works in. It is the firmware's while no child runs.
  std::span<std::byte> arena_block() const { return memory_.arena(); }
  bool has_landlock() const { return landlock_; }
  /// Whether the template has ended: nothing can be sliced any more.
  bool gone() const { return gone_; }
  pid_t template_process() const { return template_; }

  /// Starts a child on a scan.
  /// @param files  descriptors of the request's files, 1 to kMostScans; the caller closes its own
  /// @pre no child runs
  /// @retval ErrorCode::kDeviceTimeout  the template has ended
  [[nodiscard]] Status start(const ScanRequest& request, std::span<const int> files);
  [[nodiscard]] Status start(const ScanRequest& request, int file) { return start(request, std::span(&file, 1)); }
  /// Waits for the child to end. Once it has, none of its threads is left, so nothing changes the arena or the answer any more.
  /// @returns its status as wait(2) gives it; nothing: it still runs
  /// @retval ErrorCode::kDeviceTimeout  the template has ended, or was killed because it did not report the end of a killed child
  [[nodiscard]] Expected<std::optional<int>> wait(std::chrono::milliseconds patience);
  /// Kills the child. wait() then reports its end, at once unless the kernel is reading for it.
  /// @param patience  for the template to report it; of several calls the earliest end of the patience counts
  void kill(std::chrono::milliseconds patience = kEndPatience);

  const ChildProgress& progress() const { return memory_.page().progress; }
  const ScanAnswer& answer() const { return memory_.page().answer; }
  /// What the child has drawn of the job. Their sizes may be anything.
  const SlicedPictures& pictures() const { return memory_.page().pictures; }
  /// The same for the ways up that it proposes.
  const ProposalPictures& proposals() const { return memory_.page().proposals; }
  const ScanPicture& glance() const { return memory_.page().glance; }

 private:
  SlicingChild(SharedMemory memory, Descriptor socket, pid_t process)
      : memory_(std::move(memory)), socket_(std::move(socket)), template_(process) {}
  tl::unexpected<Error> has_gone();
  void end_template(std::chrono::milliseconds patience);

  SharedMemory memory_;
  Descriptor socket_;                                             ///< to the template; nothing waits for room in it
  std::optional<std::chrono::steady_clock::time_point> ends_by_;  ///< of the child that was killed
  pid_t template_ = -1;
  bool landlock_ = false;
  bool gone_ = false;
};

}  // namespace plumbline::firmware
