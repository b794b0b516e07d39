#pragma once

#include <algorithm>

#include "firmware/child/shared_memory.hpp"
#include "slicer/core/progress.hpp"

namespace plumbline::firmware {

/// Tells the firmware how far the child has come.
class SharedProgress final : public ProgressSink {
 public:
  explicit SharedProgress(ChildProgress& progress) : progress_(progress) {}

  void begin(Stage stage) override { advance(stage, 0); }
  bool advance(Stage stage, double fraction) override {
    progress_.stage.store(static_cast<std::uint32_t>(stage), std::memory_order_relaxed);
    progress_.permille.store(static_cast<std::uint32_t>(1000 * std::clamp(fraction, 0.0, 1.0)),
                             std::memory_order_relaxed);
    progress_.beats.fetch_add(1, std::memory_order_relaxed);
    return true;  // the firmware cancels with a signal
  }
  void end(Stage stage, std::size_t /*peak_bytes*/) override { advance(stage, 1); }

 private:
  ChildProgress& progress_;
};

}  // namespace plumbline::firmware
