#pragma once
/// What the checks find in a stack of masks. Names are those of UVtools' issues where it has one.

#include <array>
#include <cstdint>
#include <string_view>

namespace plumbline::inline slicer {

enum class IssueKind : std::uint8_t {
  kIsland,          ///< region of a layer with little or nothing below it
  kOverhang,        ///< new pixels that reach too far
  kFreePiece,       ///< regions that nothing holds, over all of their layers: they fall
  kTear,            ///< a piece that the film pulls at with more than holds it, and what would hang from it
  kResinTrap,       ///< enclosed air: resin that stays in the part
  kSuctionCup,      ///< air enclosed by part and film while its layers are peeled
  kTouchingBound,   ///< pixels at the edge of the panel
  kEmptyLayer,      ///< layers without a pixel
  kPrintHeight,     ///< layers above the travel
  kFirstLayerArea,  ///< the plate holds too little
  kPeelArea,        ///< a layer has more area than the film lets go easily
  kPeelJump,        ///< a layer has much more area than the one below
  kUnreached,  ///< an overhang that needs a support, to which no way leads; its pixels are the overhang that a tip would carry
  kUnreachedIsland,  ///< the same of an island
  kPlateTrap,        ///< a hollow that only the plate closes: resin stays in it until the part is taken off
  kNeedle,    ///< a column too slender for its height; its pixels are its mean section's, its place is at its foot
  kThinWall,  ///< a wall of one pixel or two
};
inline constexpr std::size_t kIssueKindCount = 17;

enum class IssueSize : std::uint8_t { kArea, kVolume, kLayers, kSlenderness };

struct IssueWords {
  std::string_view key;     ///< in profiles, options and reports: "island"
  std::string_view one;     ///< in sentences: "island"
  std::string_view many;    ///< "islands"
  IssueSize size;           ///< what ranks issues of this kind
  std::string_view advice;  ///< what to do about it
};

/// By IssueKind.
inline constexpr std::array<IssueWords, kIssueKindCount> kIssueWords = {{
    {"island", "island", "islands", IssueSize::kArea, "add supports, or turn the object"},
    {"overhang", "overhang", "overhangs", IssueSize::kArea, "add supports, or turn the object"},
    {"free_piece", "piece that nothing holds", "pieces that nothing holds", IssueSize::kVolume,
     "add supports, or turn the object"},
    {"tear", "piece that the peel tears off", "pieces that the peel tears off", IssueSize::kVolume,
     "add supports, or turn the object"},
    {"resin_trap", "resin trap", "resin traps", IssueSize::kVolume, "give the hollow a hole to drain"},
    {"suction_cup", "suction cup", "suction cups", IssueSize::kVolume,
     "turn the object, or give it a hole near the plate"},
    {"touching_bound", "part at the panel's edge", "parts at the panel's edge", IssueSize::kArea,
     "make it smaller, or move it"},
    {"empty_layer", "gap of empty layers", "gaps of empty layers", IssueSize::kLayers,
     "turn the object, since what is above a gap falls"},
    {"print_height", "part above the travel", "parts above the travel", IssueSize::kLayers,
     "make it lower, or turn it"},
    {"first_layer_area", "small first layer", "small first layers", IssueSize::kArea,
     "turn the part, since the plate may lose it, or add supports"},
    {"peel_area", "large peel area", "large peel areas", IssueSize::kArea, "lift more slowly, or turn the object"},
    {"peel_jump", "jump in area", "jumps in area", IssueSize::kArea, "turn the object so that its area grows slowly"},
    {"unreached", "overhang no support reaches", "overhangs no support reaches", IssueSize::kArea,
     "turn the object, or set orient to auto"},
    {"unreached_island", "island no support reaches", "islands no support reaches", IssueSize::kArea,
     "turn the object, or set orient to auto"},
    {"plate_trap", "hollow that drains only at the plate", "hollows that drain only at the plate", IssueSize::kVolume,
     "give it a second hole above the plate, or raise the object"},
    {"needle", "needle", "needles", IssueSize::kSlenderness, "make it thicker, or turn the object"},
    {"thin_wall", "wall of one or two pixels", "walls of one or two pixels", IssueSize::kArea,
     "make it thicker, or print it larger"},
}};
constexpr const IssueWords& words_of(IssueKind kind) { return kIssueWords[static_cast<std::size_t>(kind)]; }

/// One finding. Its place is a pixel that belongs to it, in `layer`: the middle of the widest run of pixels. That of kTear is where it
/// tears, and its pixels are those that the film pulls at.
struct Issue {
  IssueKind kind = IssueKind::kIsland;
  std::uint32_t layer = 0;        ///< where it is largest
  std::uint32_t first_layer = 0;  ///< of all its layers
  std::uint32_t last_layer = 0;
  std::uint32_t column = 0, row = 0;
  std::uint64_t pixels = 0;  ///< in `layer`; of kPeelJump: by which the area grows
  std::uint64_t voxels = 0;  ///< over all layers; of kArea kinds and needles: as `pixels`
  float asked_n = 0;         ///< of kTear: force of the peel,
  float held_n = 0;          ///< and what holds against it

  std::uint32_t layers() const { return last_layer - first_layer + 1; }
  /// What ranks it among issues of its kind.
  std::uint64_t size() const {
    switch (words_of(kind).size) {
      case IssueSize::kArea: return pixels;
      case IssueSize::kVolume: return voxels;
      case IssueSize::kLayers:
      case IssueSize::kSlenderness: return layers();
    }
    return 0;
  }
  bool operator==(const Issue&) const = default;
};

}  // namespace plumbline::inline slicer
