#pragma once
/// Every ray perfect: entering and exiting in turn, nothing left open (thesis III-4.a, DESIGN 3, stage 7).

#include <array>
#include <cstdint>
#include <span>

#include "slicer/core/print_grid.hpp"
#include "slicer/implicit/winding_number.hpp"
#include "slicer/rays/intersections.hpp"
#include "slicer/rays/ray_points.hpp"
#include "slicer/rrep/ray_crossing.hpp"

namespace plumbline {

/// What decided a ray.
enum class RayDecision : std::uint8_t {
  kOutside,   ///< not interested, or nothing on it: black at every height
  kPerfect,   ///< its intersections obey the winding rule, and the winding number of the cloud agrees
  kRepaired,  ///< uniform queries found what was missing
  kWinding,   ///< the winding number of the cloud closed what the scan had left open
  kBase,      ///< its lowest crossing is the base plane: the underside was open there
};
inline constexpr std::size_t kRayDecisionCount = 5;

/// "outside", "perfect", "repaired", "winding number", "base plane".
const char* to_string(RayDecision decision);

/// Crossings of one ray, ascending in depth; even in number: entering, exiting, entering, ...
struct ClassifiedRay {
  std::span<const RayCrossing> crossings;
  RayDecision decision = RayDecision::kOutside;
};

struct RayClassifierSettings {
  IntersectionSettings intersections;
  float repair_spacing = 0.05F;  ///< mm between the uniform queries of a repair
  /// Nothing of the surface faces down, and there is a base plane: what lies below the lowest sheet of a ray is solid, seen
  /// from the side or not.
  bool height_field = false;
};

/// Decides one ray after another, tile by tile. One object a thread. What it has found out on the way serves the tiles of one
/// column of kColumnSide x kColumnSide rays; the result does not depend on the order of the tiles.
///
/// Between the bands where the scan is near, a ray is either inside or outside all along, or it passes through a hole of
/// the scan. Which of them is known from both neighbouring bands and, independently, from the winding number of the whole
/// cloud; where those disagree the winding number has the last word, since it weighs every point of the scan and the band
/// only a handful.
class RayClassifier {
 public:
  static constexpr std::uint32_t kColumnSide = 2 * kTileSide;  ///< rays
  static constexpr std::uint32_t kMaxCrossings = 254;          ///< a ray; of more, the thinnest stretches are dropped

  static std::size_t bytes_needed(std::uint32_t tile_capacity);
  [[nodiscard]] static Expected<RayClassifier> create(const Cloud& cloud, const KdTree2& tree,
                                                      const WindingTree& winding, const PrintGrid& grid,
                                                      float max_radius, std::uint32_t tile_capacity,
                                                      const RayClassifierSettings& settings, Arena& arena);

  /// Turns to the tile whose first ray is pixel (column, row); kTileSide rays a side.
  void begin_tile(std::uint32_t column, std::uint32_t row);
  /// A ray of that tile. The spans last until the next call.
  ClassifiedRay ray(std::uint32_t column, std::uint32_t row);

  bool tile_thinned() const { return gatherer_.thinned(); }

 private:
  enum class Verdict : std::uint8_t { kUnknown, kOutside, kInside, kUnsure };
  /// A stretch of a ray between two bands: inside or outside at both ends, crossings in between.
  struct Gap {
    bool inside_at_low, inside_at_high;
  };

  /// On the way up through a gap.
  struct GapWalk {
    float x, y;
    float at;     ///< mm, where the last answer is from; first the lower shore
    bool inside;  ///< there
    bool begun = false;
    bool inside_at_low = false;  ///< what the lower shore must be
  };
  /// What winding numbers at fixed levels say between the bands, for a block of rays. Between rays that no point separates
  /// they change slowly: the first ray of the block that asks for a level answers for all of it. Levels that no point of the
  /// tile reaches are answered before, for all of its rays, by the middle of the column of tiles, where that is sure.
  struct LevelSet {
    std::uint64_t known = 0;  ///< bit k: level k has been asked
    std::uint64_t inside = 0;

    bool knows(std::uint32_t level) const { return (known >> level & 1U) != 0; }
    bool is_inside(std::uint32_t level) const { return (inside >> level & 1U) != 0; }
    void set(std::uint32_t level, bool is_inside) {
      known |= std::uint64_t{1} << level;
      inside |= std::uint64_t{is_inside} << level;
    }
  };
  static constexpr std::uint32_t kLevels = 64;
  static constexpr std::uint32_t kBlock = 4;  ///< rays a side
  float level_height(std::uint32_t level) const {
    return top_ * (static_cast<float>(level) + 0.5F) / static_cast<float>(kLevels);
  }
  bool level_inside(std::uint32_t level, float x, float y);
  void step(GapWalk& walk, float z, bool inside);
  void walk_levels(GapWalk& walk, float high);

  void judge_tile(std::uint32_t level);
  void bisect(float x, float y, float from, float to, bool inside_at_from);
  bool alternates(const RaySurface& surface) const;
  Gap decide_gap(float x, float y, float low, float high, bool below, bool above);
  /// Whether the winding number has x on that side and no sheet alone makes it so.
  bool more_than_a_sheet(const Vec3f& x, bool is_inside) const;
  /// Emits a crossing between the end of a band, which the gap beside it says is not what the band has it, and a place in the
  /// band, if the winding number agrees with both.
  bool bisect_agreed(float x, float y, float end, float place, bool inside_at_end);
  void cross_band(float x, float y, const RaySurface& surface, const Band& band, bool from, bool to);
  void emit(float depth, Evidence evidence, bool extrapolated = false);
  void remember(const RaySurface& surface);
  Evidence evidence_of(float depth) const;
  void drop_thin_stretches();

  RayGatherer gatherer_;
  RaySolver solver_;
  const WindingTree* winding_ = nullptr;
  PrintGrid grid_;
  RayClassifierSettings settings_;
  std::span<RayCrossing> crossings_;
  /// Verdicts at the levels in the middle of the column of tiles that the tile belongs to, made when first asked for.
  std::array<Verdict, kLevels> column_verdicts_{};
  Vec2f column_centre_ = Vec2f::Constant(-1);
  std::array<LevelSet, (kTileSide / kBlock) * (kTileSide / kBlock)> levels_{};
  std::uint32_t ray_block_ = 0;  ///< of levels_, that the ray belongs to
  std::uint32_t crossing_count_ = 0;
  /// Intersections of the ray that were found at the first look, mm: those of most rays. The others count as repaired.
  static constexpr std::uint32_t kFirstLook = 32;
  std::array<float, kFirstLook> first_look_{};
  std::uint32_t first_look_count_ = 0;
  float floor_ = 0;  ///< mm, base plane
  float top_ = 0;    ///< mm
  bool used_winding_ = false;
};

}  // namespace plumbline
