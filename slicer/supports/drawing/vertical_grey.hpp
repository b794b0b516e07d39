#pragma once
/// Grey pixels where rays enter the object, so that undersides lie between the heights of layers.

#include <cstdint>

#include "slicer/core/arena.hpp"
#include "slicer/core/bit_image.hpp"
#include "slicer/core/error.hpp"
#include "slicer/core/grey_runs.hpp"
#include "slicer/core/resin/cure_model.hpp"
#include "slicer/rrep/rrep.hpp"
#include "slicer/supports/drawing/entering_levels.hpp"
#include "slicer/supports/drawing/support_cover.hpp"

namespace plumbline::inline slicer {

/// Finds the grey pixels of masks. A ray that enters at a height between two layers' gets the share of the lower layer's light that brings the
/// front there. What faces up has none: light comes from below, so there a layer cures whole or not at all. Bottom and faded layers have
/// none, nor have rays that are in no other layer, and what supports cover. A pixel whose bit is set cures by its own light, as the layer's checks
/// expect; one whose bit is not set, and that has no white pixel beside it, does not: it would hang on nothing.
class VerticalGrey {
 public:
  /// @param rrep, supports    of the print; must outlive this
  /// @param layer_height_mm   by which the plate moves
  /// @retval ErrorCode::kOutOfMemory  no room for bytes_needed() at the bottom of the arena
  [[nodiscard]] static Expected<VerticalGrey> create(const RRep& rrep, const Supports& supports, const CureModel& model,
                                                     double layer_height_mm, Arena& arena);
  static std::size_t bytes_needed(const PrintGrid& grid, std::size_t supports) {
    return SupportCover::bytes_needed(grid, supports);
  }

  /// @param section, mask  of the layer: MaskStream's, asked for it last. A grey pixel's bit is set if its surface is in the lower half of the layer
  /// @param greys          overwritten
  void find(std::uint32_t layer, ConstBitImage section, ConstBitImage mask, GreyRuns& greys);

 private:
  VerticalGrey(const RRep& rrep, const CureModel& model, double layer_height_mm, const SupportCover& supports)
      : rrep_(&rrep),
        packing_(rrep.grid),
        first_(model.bottom_layers + model.faded_layers),
        levels_(model, layer_height_mm),
        supports_(supports) {}

  const RRep* rrep_;
  CrossingPacking packing_;
  std::uint32_t first_;  ///< layer
  EnteringLevels levels_;
  SupportCover supports_;
};

/// Whether one of the four pixels beside one is white.
inline bool has_white_beside(ConstBitImage mask, std::uint32_t column, std::uint32_t row) {
  return (column > 0 && mask.at(column - 1, row)) || (column + 1 < mask.columns() && mask.at(column + 1, row)) ||
         (row > 0 && mask.at(column, row - 1)) || (row + 1 < mask.rows() && mask.at(column, row + 1));
}

}  // namespace plumbline::inline slicer
