#pragma once
/// Progress and cancellation of a parallel loop.

#include <omp.h>

#include <algorithm>
#include <atomic>
#include <cstdint>

#include "slicer/core/progress.hpp"

namespace plumbline::inline slicer {

/// Reports the progress of a parallel loop from one of its threads, and stops all of them when the caller cancels.
class LoopProgress {
 public:
  /// @param steps  iterations of the loop, which OpenMP may hand out in any order
  LoopProgress(const StageProgress& progress, std::uint32_t steps) : progress_(progress), steps_(steps) {}
  /// Call at the start of each step, in the thread that runs it.
  /// @returns false if the step is to be skipped
  bool step(std::uint32_t number) {
    if (number % kChunk == 0) {
      // The count of begun chunks only grows, so the progress never goes back. The step's number may.
      const std::uint32_t begun = begun_.fetch_add(1, std::memory_order_relaxed);
      if (omp_get_thread_num() == 0 && !progress_.advance(1.0 * begun * kChunk / steps_)) stop_ = true;
    }
    return !stop_.load(std::memory_order_relaxed);
  }
  /// Skips all further steps. Call from any thread.
  void stop() { stop_ = true; }
  bool stopped() const { return stop_; }

 private:
  static constexpr std::uint32_t kChunk = 64;  ///< steps between two reports: some 10 ms of work
  StageProgress progress_;
  std::uint32_t steps_;
  std::atomic<std::uint32_t> begun_ = 0;  ///< chunks, by all threads
  std::atomic<bool> stop_ = false;
};

/// Calls `visit(begin, end)` for every block of indices below `size`, from several threads.
/// @param block  indices a call, the last one fewer
/// @returns false if the caller of the stage cancelled
template <class Visit>
bool for_blocks(std::uint32_t size, std::uint32_t block, const StageProgress& progress, Visit visit) {
  const std::uint32_t blocks = (size + block - 1) / block;
  LoopProgress loop(progress, blocks);
#pragma omp parallel for schedule(dynamic, 64)
  for (std::uint32_t b = 0; b < blocks; ++b) {
    if (loop.step(b)) visit(b * block, std::min(size, (b + 1) * block));
  }
  return !loop.stopped();
}

}  // namespace plumbline::inline slicer
