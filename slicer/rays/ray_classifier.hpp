#pragma once
/// Decides the crossings of every ray, so that they alternate between entering and exiting (thesis III-4.a).

#include <array>
#include <cstdint>
#include <optional>
#include <span>

#include "slicer/core/print_grid.hpp"
#include "slicer/implicit/column_winding.hpp"
#include "slicer/rays/intersections.hpp"
#include "slicer/rays/ray_points.hpp"
#include "slicer/rrep/ray_crossing.hpp"

namespace plumbline::inline slicer {

/// What decided the crossings of a ray.
enum class RayDecision : std::uint8_t {
  kOutside,  ///< no crossings, though points are near: black at every height
  kPerfect,  ///< its intersections alternate, and the winding number of the cloud agrees
  kWinding,  ///< the winding number of the cloud added or moved crossings
  kBase,     ///< its lowest crossing is the base plane, under an open underside
  kAway,     ///< no crossings, and outside of all supports; not counted
};
inline constexpr std::size_t kRayDecisionCount = 4;

/// "outside", "perfect", "winding number", "base plane".
const char* to_string(RayDecision decision);

/// Crossings of one ray, ascending in depth, even in number: entering, exiting, entering, ...
struct ClassifiedRay {
  std::span<const RayCrossing> crossings;
  RayDecision decision = RayDecision::kOutside;
};

/// What rays are shot through.
struct RayField {
  const Cloud* cloud = nullptr;
  const KdTree2* tree = nullptr;
  const WindingTree* winding = nullptr;
  PrintGrid grid;
  float width = 0.1F;  ///< w of thesis III-2.c, mm
  SupportWidths widths;
  std::uint32_t tile_capacity = 0;  ///< points
  /// Nothing of the surface faces down and there is a base plane, so the ray is solid below its lowest crossing, whether the
  /// side walls were scanned or not.
  bool height_field = false;
};

/// Decides one ray after another, tile by tile. One object a thread. Winding numbers are cached for the tiles of a column of
/// kColumnSide x kColumnSide rays; the result does not depend on the order of the tiles.
///
/// In the gap between two bands a ray is inside all along, outside all along, or passes a hole in the scan. Both bands and the
/// winding number of the cloud are evidence for this. Where they disagree the winding number wins, since it weighs all points
/// of the scan and a band only a few.
class RayClassifier {
 public:
  static constexpr std::uint32_t kColumnTiles = 4;                        ///< a side
  static constexpr std::uint32_t kColumnSide = kColumnTiles * kTileSide;  ///< rays
  static constexpr std::uint32_t kMaxCrossings =
      254;  ///< a ray; if it has more, the thinnest intervals are dropped. Counts fit a byte

  static std::size_t bytes_needed(std::uint32_t tile_capacity);
  [[nodiscard]] static Expected<RayClassifier> create(const RayField& field, Arena& arena);

  /// Begins the tile whose first ray is pixel (column, row); kTileSide rays a side.
  void begin_tile(std::uint32_t column, std::uint32_t row);
  /// Decides a ray of that tile. The spans are valid until the next call.
  ClassifiedRay ray(std::uint32_t column, std::uint32_t row);

  /// Depth of the surface near a predicted depth on a ray of that tile, mm; nothing if there is none.
  std::optional<float> sheet_near(std::uint32_t column, std::uint32_t row, float depth, bool entering);

  const PrintGrid& grid() const { return field_.grid; }
  const RayGatherer& gatherer() const { return gatherer_; }

 private:
  enum class Verdict : std::uint8_t { kUnknown, kOutside, kInside, kUnsure };
  /// The part of a ray between two bands.
  struct Gap {
    bool inside_at_low, inside_at_high;
  };

  /// Inside or outside by the winding number at fixed levels, for a block of rays. Away from points the number changes slowly,
  /// so the first ray of the block for which a level is sure (kSure) answers for all. Levels that no point of the tile reaches are
  /// answered for the whole tile by the corner in which it meets three others of its column, if the number there is sure (kSure).
  struct LevelSet {
    std::uint64_t known = 0;  ///< bit k: level k is answered
    std::uint64_t inside = 0;

    bool knows(std::uint32_t level) const { return (known >> level & 1U) != 0; }
    bool is_inside(std::uint32_t level) const { return (inside >> level & 1U) != 0; }
    void set(std::uint32_t level, bool is_inside) {
      known |= std::uint64_t{1} << level;
      inside |= std::uint64_t{is_inside} << level;
    }
  };
  static constexpr std::uint32_t kLevels = 64;
  static constexpr std::uint32_t kMeetingSide = 2 * kTileSide;  ///< rays
  static constexpr std::uint32_t kMeetings = kColumnTiles / 2;  ///< along a side of a column
  static constexpr std::uint32_t kBlock = 4;                    ///< rays a side
  /// Where the ends of a gap agree, only every kStride-th level is checked. A thinner solid of which the scan shows neither
  /// underside nor top is missed.
  static constexpr std::uint32_t kStride = 4;
  float level_height(std::uint32_t level) const {
    return top_ * (static_cast<float>(level) + 0.5F) / static_cast<float>(kLevels);
  }
  bool level_inside(std::uint32_t level, float x, float y);

  void judge_tile(std::uint32_t level);
  void bisect(float x, float y, float from, float to, bool inside_at_from);
  bool gap_agrees(float x, float y, float low, float high, bool inside);
  Gap decide_gap(float x, float y, float low, float high, bool below, bool above);
  /// Emits a crossing between the end of a band, where gap and band disagree, and a place in the band, if the winding number
  /// agrees with the gap at the end and with the band at the place.
  bool bisect_agreed(float x, float y, float end, float place, bool inside_at_end);
  void cross_band(float x, float y, const RaySurface& surface, const Band& band, bool from, bool to);
  void emit(float depth, Evidence evidence, bool extrapolated = false);
  void drop_thin_stretches();

  RayGatherer gatherer_;
  RaySolver solver_;
  ColumnWinding winding_;
  RayField field_;
  std::span<RayCrossing> crossings_;
  /// Verdicts at the levels in each place of the column where four tiles meet, found when first needed.
  std::array<std::array<Verdict, kLevels>, kMeetings * kMeetings> verdicts_{};
  Vec2f column_corner_ = Vec2f::Constant(-1);
  Vec2f meeting_ = Vec2f::Zero();     ///< of the tile, mm
  std::uint32_t meeting_number_ = 0;  ///< index into verdicts_
  std::array<LevelSet, (kTileSide / kBlock) * (kTileSide / kBlock)> levels_{};
  std::uint64_t free_levels_ = 0;  ///< bit k: no point of the tile reaches level k
  std::uint32_t ray_block_ = 0;    ///< index into levels_ for the ray
  std::uint32_t crossing_count_ = 0;
  float floor_ = 0;  ///< mm, base plane
  float top_ = 0;    ///< mm
  bool used_winding_ = false;
};

}  // namespace plumbline::inline slicer
