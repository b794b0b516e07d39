#pragma once
/// What every stage of a job is given, and the scope that it runs in.

#include <algorithm>
#include <array>
#include <cstddef>

#include "slicer/core/arena.hpp"
#include "slicer/core/progress.hpp"

namespace plumbline::inline slicer {

/// Bytes of the arena, by Stage.
struct StageMemory {
  std::array<std::size_t, kStageCount> planned_bytes = {};
  std::array<std::size_t, kStageCount> peak_bytes = {};  ///< most in use

  std::size_t& planned(Stage stage) { return planned_bytes[static_cast<std::size_t>(stage)]; }
  std::size_t& peak(Stage stage) { return peak_bytes[static_cast<std::size_t>(stage)]; }
};

/// What every stage of a job is given.
struct StageContext {
  Arena& arena;
  ProgressSink* progress;  ///< may be null
  StageMemory& memory;     ///< set by each stage, also by one that fails
};

/// Reports the start and the end of a stage, and records how much of the arena it used.
class StageScope {
 public:
  /// The destructor sets the stage's peak, to the most if the stage runs in several parts.
  StageScope(Stage stage, const StageContext& context) : stage_(stage), context_(context) {
    context_.arena.reset_peak();
    if (context_.progress != nullptr) context_.progress->begin(stage_);
  }
  ~StageScope() {
    std::size_t& most = context_.memory.peak(stage_);
    most = std::max(most, context_.arena.peak());
    if (context_.progress != nullptr) context_.progress->end(stage_, context_.arena.peak());
  }
  StageScope(const StageScope&) = delete;
  StageScope& operator=(const StageScope&) = delete;

 private:
  Stage stage_;
  StageContext context_;
};

}  // namespace plumbline::inline slicer
