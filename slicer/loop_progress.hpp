#pragma once
/// Progress and cancelling of a parallel loop.

#include <omp.h>

#include <atomic>
#include <cstdint>

#include "slicer/core/progress.hpp"

namespace plumbline {

/// Lets one of the threads of a parallel loop tell the progress, and all of them hear that they shall stop.
class LoopProgress {
 public:
  /// @param steps  of the loop, which must deal them out in ascending order: schedule(dynamic)
  LoopProgress(const StageProgress& progress, std::uint32_t steps) : progress_(progress), steps_(steps) {}
  /// At the start of a step, in the thread that does it.
  /// @returns false: leave out the step
  bool step(std::uint32_t number) {
    if (number % kChunk == 0 && omp_get_thread_num() == 0 && !progress_.advance(1.0 * number / steps_)) stop_ = true;
    return !stop_.load(std::memory_order_relaxed);
  }
  bool stopped() const { return stop_; }

 private:
  static constexpr std::uint32_t kChunk = 64;  ///< steps between two looks: some 10 ms of work
  StageProgress progress_;
  std::uint32_t steps_;
  std::atomic<bool> stop_ = false;
};

}  // namespace plumbline
