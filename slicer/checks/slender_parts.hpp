#pragma once
/// Columns that are too slender, and walls of one pixel or two.

#include <cstdint>
#include <span>

#include "slicer/checks/overhangs.hpp"
#include "slicer/checks/stack_findings.hpp"
#include "slicer/core/arena.hpp"
#include "slicer/core/bit_image.hpp"
#include "slicer/core/error.hpp"
#include "slicer/core/print_grid.hpp"
#include "slicer/core/regions/layer_regions.hpp"

namespace plumbline::inline slicer {

/// Looks at a layer every quarter of a millimetre, and follows what it sees from look to look by the boxes round it.
///   - A needle is at least CheckLimits::kNeedleRatio times as high as it is wide, and no section of it is twice as wide as a square of its
///     area: a fin and a tube are none. It begins where a section has at most a quarter of the area below it.
///   - Thin pixels are in runs of at most two along their row or their column. A thin wall is CheckLimits::kThinWall_mm long and high.
class SlenderParts {
 public:
  /// @retval ErrorCode::kOutOfMemory  bytes_needed() from the top of the arena
  [[nodiscard]] static Expected<SlenderParts> create(const PrintGrid& grid, Arena& arena);
  static std::size_t bytes_needed() { return Arena::rounded(kMost * sizeof(Part)); }

  bool looks_at(std::uint32_t layer) const { return layer % step_ == 0; }
  /// @param box   round all white pixels
  /// @param thin  of the mask's size; its words in `box` are overwritten
  /// @returns whether there are enough thin pixels for a wall
  bool find_thin(ConstBitImage mask, const RegionBox& box, BitImage thin) const;
  /// Takes a region of the layer looked at.
  /// @param section  issue_at() of it: kNeedle for one of the mask, kThinWall for one of thin pixels
  void add(const Issue& section, const LayerRegions& regions, std::uint32_t region);
  /// Adds what the look at `layer` has not continued to the findings; after the last layer all.
  void end_look(std::uint32_t layer, StackFindings& findings);

 private:
  static constexpr std::size_t kMost = 2048;  ///< followed at once
  struct Part {
    RegionBox box;  ///< at the last look
    Issue issue;    ///< pixels: at the last look; voxels: of all looks
  };

  IssueScale scale_;
  std::uint32_t step_;  ///< layers from look to look
  std::span<Part> parts_;
  std::size_t count_ = 0;

  SlenderParts(const PrintGrid& grid, std::span<Part> parts);
};

}  // namespace plumbline::inline slicer
