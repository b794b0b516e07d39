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
  /// @param steps  of the loop, dealt out in any order: a thread that has run out of its own may take another's
  LoopProgress(const StageProgress& progress, std::uint32_t steps) : progress_(progress), steps_(steps) {}
  /// At the start of a step, in the thread that does it.
  /// @returns false: leave out the step
  bool step(std::uint32_t number) {
    if (number % kChunk == 0) {
      // What one thread reads of a count that only grows never goes back; the number of its step may.
      const std::uint32_t begun = begun_.fetch_add(1, std::memory_order_relaxed);
      if (omp_get_thread_num() == 0 && !progress_.advance(1.0 * begun * kChunk / steps_)) stop_ = true;
    }
    return !stop_.load(std::memory_order_relaxed);
  }
  bool stopped() const { return stop_; }

 private:
  static constexpr std::uint32_t kChunk = 64;  ///< steps between two looks: some 10 ms of work
  StageProgress progress_;
  std::uint32_t steps_;
  std::atomic<std::uint32_t> begun_ = 0;  ///< chunks, by all threads
  std::atomic<bool> stop_ = false;
};

}  // namespace plumbline
