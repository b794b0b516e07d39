#pragma once
/// Reports the start and end of a stage, and records how much of the arena it used.

#include <algorithm>
#include <array>
#include <cstddef>

#include "slicer/core/arena.hpp"
#include "slicer/core/progress.hpp"

namespace plumbline {

class StageScope {
 public:
  /// @param progress    may be null
  /// @param peak_bytes  indexed by Stage; the destructor sets the stage's entry, to the most if it runs in several parts
  StageScope(Stage stage, Arena& arena, ProgressSink* progress, std::array<std::size_t, kStageCount>& peak_bytes)
      : stage_(stage), arena_(arena), progress_(progress), peak_bytes_(peak_bytes) {
    arena_.reset_peak();
    if (progress_ != nullptr) progress_->begin(stage_);
  }
  ~StageScope() {
    std::size_t& most = peak_bytes_[static_cast<std::size_t>(stage_)];
    most = std::max(most, arena_.peak());
    if (progress_ != nullptr) progress_->end(stage_, arena_.peak());
  }
  StageScope(const StageScope&) = delete;
  StageScope& operator=(const StageScope&) = delete;

 private:
  Stage stage_;
  Arena& arena_;
  ProgressSink* progress_;
  std::array<std::size_t, kStageCount>& peak_bytes_;
};

}  // namespace plumbline
