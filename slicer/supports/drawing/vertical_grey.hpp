#pragma once
/// Grey pixels where rays enter the object, so that undersides lie between the heights of layers.

#include <array>
#include <cstdint>

#include "slicer/core/arena.hpp"
#include "slicer/core/bit_image.hpp"
#include "slicer/core/error.hpp"
#include "slicer/core/grey_runs.hpp"
#include "slicer/core/resin/cure_model.hpp"
#include "slicer/rrep/rrep.hpp"
#include "slicer/supports/drawing/support_painter.hpp"

namespace plumbline::inline slicer {

/// The least share of a layer's light with which the front of the cured resin lies `share` of a layer higher than with all of it, if the
/// layers above are lit. Solves combined(g) = Ec for the dose of CureModel.
/// @param share  0 to 1
/// @returns 0 to 1, the same on every machine; 1 - share if the model is not known
double grey_of(const CureModel& model, double layer_height_mm, double share);

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
  static std::size_t bytes_needed(const PrintGrid& grid, std::size_t supports);

  /// @param section, mask  of the layer: MaskStream's, asked for it last. A grey pixel's bit is set if its surface is in the lower half of the layer
  /// @param greys          overwritten
  void find(std::uint32_t layer, ConstBitImage section, ConstBitImage mask, GreyRuns& greys);

 private:
  VerticalGrey(const RRep& rrep, const CureModel& model, double layer_height_mm);
  void draw_supports(std::uint32_t layer);
  void clear_supports();

  const RRep* rrep_;
  CrossingPacking packing_;
  std::uint32_t first_;  ///< layer
  std::array<std::uint8_t, CrossingHeight::kParts> levels_ =
      {};                                  ///< by the part of a crossing's height; 0: no light, 255: all
  std::uint32_t most_alone_ = kFullLevel;  ///< of a pixel that is to cure with the next layer's light only
  bool has_supports_ = false;
  SupportPainter painter_;
  BitImage supports_;  ///< of the layer
  BitImage drawn_;     ///< as SupportPainter::draw() says
};

}  // namespace plumbline::inline slicer
