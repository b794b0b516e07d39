#pragma once
/// How much of the whole of slicing is done, for one bar that never goes back.

#include "slicer/core/progress.hpp"

namespace plumbline::firmware {

/// From the stages as they come, 0 to 1. Each stage gets the share of what is left that its weight has among the stages that may
/// still come. So stages that are left out, as with a mesh, and those that run again, as after averaging, only change the bar's
/// speed; and it ends at 1.
class WholeProgress {
 public:
  /// @param last    the stage that the work ends with
  /// @param writes  the layers are written to a disk, not only checked
  explicit WholeProgress(Stage last = Stage::kLayers, bool writes = false) : last_(last), writes_(writes) {}

  /// Call it in the order of the work. Stages may be missed.
  /// @param fraction  of the stage, 0 to 1
  /// @returns of the whole, 0 to 1, never less than before
  double reach(Stage stage, double fraction);

  bool writes() const { return writes_; }

 private:
  Stage last_;
  bool writes_;
  bool begun_ = false;
  Stage stage_ = Stage::kRead;
  double from_ = 0, to_ = 0;  ///< of the whole: where stage_ begins and ends
  double reached_ = 0;
};

}  // namespace plumbline::firmware
