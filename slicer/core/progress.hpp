#pragma once
/// Progress reports to the caller. The slicer has no clock: a caller that wants times takes them here.

#include <cstddef>
#include <cstdint>
#include <string_view>

namespace plumbline::inline slicer {

/// The stages of the slicer, in the order in which they run.
enum class Stage : std::uint8_t {
  kRead,
  kNormals,
  kTrees,
  kViews,
  kClustering,
  kWindingTree,
  kRayGrid,
  kRays,
  kRRep,
  kSupports,
  kLayers,
};
inline constexpr std::size_t kStageCount = 11;

/// "read", "normals", ...: one word, lower case.
std::string_view to_string(Stage stage);

class ProgressSink {
 public:
  virtual ~ProgressSink() = default;
  virtual void begin(Stage stage) = 0;
  /// Called often, from one thread only.
  /// @param fraction  of the stage, 0 to 1
  /// @returns false to cancel: the stage returns ErrorCode::kCancelled
  virtual bool advance(Stage stage, double fraction) = 0;
  /// @param peak_bytes  most bytes of the arena in use while the stage ran
  virtual void end(Stage stage, std::size_t peak_bytes) = 0;
  /// Called between stages if no surface was found: neighbours are averaged, and the stages from Stage::kTrees on run again.
  /// @param points  before that
  virtual void averages(std::uint32_t /*points*/) {}
  /// Called within Stage::kNormals if the scan plainly lies wrong, at most once unless neighbours are averaged.
  /// @param x_degrees, y_degrees  rotation about x, then about y, that puts it upright
  virtual void lies_wrong(double /*x_degrees*/, double /*y_degrees*/) {}
};

/// Maps the progress of one step, 0 to 1, to its part of a stage. A step need not know which stage it serves.
struct StageProgress {
  ProgressSink* sink = nullptr;
  Stage stage = Stage::kRead;
  double from = 0, to = 1;  ///< fractions of the stage

  /// Call from one thread only.
  /// @param fraction  of this part, 0 to 1
  /// @returns false to cancel
  bool advance(double fraction) const { return sink == nullptr || sink->advance(stage, from + (to - from) * fraction); }
  /// A part of this part: from `first` to `last`, 0 to 1.
  StageProgress part(double first, double last) const {
    return {sink, stage, from + (to - from) * first, from + (to - from) * last};
  }
};

}  // namespace plumbline::inline slicer
