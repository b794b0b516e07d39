#pragma once
/// A progress sink that cancels a job.

#include "slicer/core/progress.hpp"

namespace plumbline::testing {

/// Cancels at the third report of progress.
class StopAtThird final : public ProgressSink {
 public:
  void begin(Stage /*stage*/) override {}
  bool advance(Stage /*stage*/, double fraction) override { return ++reports < 3 && fraction < 1; }
  void end(Stage /*stage*/, std::size_t /*peak_bytes*/) override {}
  int reports = 0;
};

}  // namespace plumbline::testing
