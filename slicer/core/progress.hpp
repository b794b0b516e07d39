#pragma once
/// What a caller hears while the slicer works. The slicer has no clock: who wants seconds takes the time here.

#include <cstddef>
#include <cstdint>
#include <string_view>

namespace plumbline {

/// The stages of DESIGN section 3, in the order of the data's way.
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
  /// @param fraction  0 to 1 of the stage; often, and from one thread only
  /// @returns false to cancel: the stage returns ErrorCode::kCancelled
  virtual bool advance(Stage stage, double fraction) = 0;
  /// @param peak_bytes  highest use of the arena while the stage ran
  virtual void end(Stage stage, std::size_t peak_bytes) = 0;
};

/// A part of a stage's progress, for who works for the stage without knowing it.
struct StageProgress {
  ProgressSink* sink = nullptr;
  Stage stage = Stage::kRead;
  double from = 0, to = 1;  ///< of the stage

  /// @param fraction  0 to 1 of the part; from one thread only
  /// @returns false to cancel
  bool advance(double fraction) const { return sink == nullptr || sink->advance(stage, from + (to - from) * fraction); }
  StageProgress part(double first, double last) const {
    return {sink, stage, from + (to - from) * first, from + (to - from) * last};
  }
};

}  // namespace plumbline
