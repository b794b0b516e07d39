#pragma once
/// Islands and holes in the layers that are too small to be more than a fault of the scan (DESIGN 3, stage 9).

#include <cstdint>
#include <optional>

#include "slicer/core/arena.hpp"
#include "slicer/core/error.hpp"
#include "slicer/layers/layer_totals.hpp"
#include "slicer/rrep/rrep.hpp"

namespace plumbline {

struct FeatureLimits {
  std::uint32_t pixels = 0;         ///< of one layer: a region of more is no small one
  std::uint64_t voxels = 0;         ///< of one feature over all of its layers
  std::uint32_t narrow_pixels = 0;  ///< a feature none of whose regions has more is narrow
  std::uint32_t narrow_layers = 0;  ///< of a narrow feature: a higher one is no fault of the scan
  std::uint32_t flat_layers = 0;    ///< of any other
  std::uint64_t loose_voxels = 0;   ///< of a feature that touches nothing: it goes whatever its form
};

struct FeatureCounts {
  bool counted = false;       ///< false: the arena had no room to look, and everything stayed
  std::uint32_t islands = 0;  ///< taken out
  std::uint32_t holes = 0;    ///< filled
  std::uint64_t voxels = 0;   ///< of both
  /// Counted by the way. Known if the sweep reached the last layer and left all masks as they were.
  std::optional<LayerTotals> totals;

  FeatureCounts& operator+=(const FeatureCounts& other) {
    counted |= other.counted;
    islands += other.islands;
    holes += other.holes;
    voxels += other.voxels;
    totals = other.totals;
    return *this;
  }
};

/// Bytes of arena beside the R-Rep that drop_small_features() takes.
std::size_t layer_features_bytes(const PrintGrid& grid);

/// Takes out the small islands and fills the small holes of the layers.
///
/// A feature is what the small regions of consecutive layers make together. Where the scan has smoothed a crease, the
/// surface dips under it, and the layers there have a hole of a few pixels that two layers on is open to the outside; a
/// bump is an island first. Such a feature is removed: the regions that it touches above and below go on without it, so
/// nothing begins, ends or is held by it. What stays is what a larger region is the only continuation of, the tip of a
/// thing that grows and the bottom of a pit that widens, and everything of more voxels or layers, so needles and shafts too,
/// and the dots of a text in Braille: noise makes flat crumbs, strays and creases narrow ones that are not high. Islands stay
/// if without them a larger one would hang in the air, or under nothing. What touches nothing at all goes, such as what the
/// opening of the masks has cut off, unless no layer has a larger island.
///
/// Works on the masks as they are shown, opened and closed, and edits the crossings.
/// There is room for so many small regions; where a scan has more, the layers above stay as they are.
/// @param rrep   the newest block at the bottom of the arena; its crossings may become more or fewer
/// @param arena  layer_features_bytes() of scratch, given back
/// @retval ErrorCode::kOutOfMemory  the edited crossings do not fit; some of the features may be gone
[[nodiscard]] Expected<FeatureCounts> drop_small_features(RRep& rrep, const FeatureLimits& limits, Arena& arena);

}  // namespace plumbline
