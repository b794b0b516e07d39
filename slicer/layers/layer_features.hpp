#pragma once
/// Removes islands and holes of layers that are below what the scan resolves.

#include <cstdint>
#include <optional>

#include "slicer/core/arena.hpp"
#include "slicer/core/error.hpp"
#include "slicer/layers/layer_totals.hpp"
#include "slicer/rrep/rrep.hpp"

namespace plumbline::inline slicer {

struct FeatureLimits {
  std::uint32_t pixels = 0;         ///< in one layer: a region with more is not small
  std::uint64_t voxels = 0;         ///< of a feature, over all of its layers
  std::uint32_t narrow_pixels = 0;  ///< a feature is narrow if none of its regions has more
  std::uint32_t narrow_layers = 0;  ///< height of a narrow feature; higher ones stay
  std::uint32_t flat_layers = 0;    ///< height of any other feature
  std::uint64_t loose_voxels = 0;   ///< of a feature that touches nothing, whatever its shape
};

struct FeatureCounts {
  bool counted = false;       ///< false: the arena had no room, and nothing was removed
  std::uint32_t islands = 0;  ///< removed
  std::uint32_t holes = 0;    ///< filled
  std::uint64_t voxels = 0;   ///< of both
  /// Counted in the same sweep. Known if it reached the last layer and left all masks as they were.
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

/// Removes small islands and fills small holes of the layers.
///
/// A feature is a set of small regions of consecutive layers that touch. Example: where the scan has smoothed a crease, the
/// surface dips under it, so a layer has a hole of a few pixels that opens to the outside two layers on. A bump begins as an
/// island in the same way. Noise makes flat features, outliers and creases make narrow, low ones.
///
/// These stay:
///   - a feature that alone touches a larger region from above or below: the tip of a growing part, a pit's bottom;
///   - a feature with more voxels or layers than the limits: needles, shafts, the dots of Braille;
///   - an island between two larger ones, if without it one of them would hang in the air.
/// A feature that touches nothing, such as one that the mask's opening has cut off, is removed unless no layer has a
/// larger island.
///
/// Works on opened and closed masks, and edits the crossings. If a scan has more small regions than there is room for, the
/// layers above stay as they are.
/// @param rrep   the newest block at the bottom of the arena; its crossings may become more or fewer
/// @param arena  layer_features_bytes() of scratch, given back
/// @retval ErrorCode::kOutOfMemory  the edited crossings do not fit; some of the features may be gone
[[nodiscard]] Expected<FeatureCounts> drop_small_features(RRep& rrep, const FeatureLimits& limits, Arena& arena);

}  // namespace plumbline::inline slicer
