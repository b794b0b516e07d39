#pragma once
/// The rays that enter or leave the object in a layer, and which share of its light those get that enter between two layers' heights.

#include <array>
#include <cstdint>
#include <span>

#include "slicer/core/bit_image.hpp"
#include "slicer/core/grey_runs.hpp"
#include "slicer/core/resin/cure_model.hpp"
#include "slicer/rrep/rrep.hpp"

namespace plumbline::inline slicer {

/// The least share of a layer's light with which the front of the cured resin lies `share` of a layer higher than with all of it, if the
/// layers above are lit. Solves combined(g) = Ec for the dose of CureModel.
/// @param share  0 to 1
/// @returns 0 to 1, the same on every machine; 1 - share if the model is not known
double grey_of(const CureModel& model, double layer_height_mm, double share);

/// Levels of a layer's light.
struct EnteringLevels {
  /// @param layer_height_mm  by which the plate moves
  EnteringLevels(const CureModel& model, double layer_height_mm);

  std::array<std::uint8_t, CrossingHeight::kParts> by_part = {};  ///< of a crossing's height; 0: no light, 255: all
  std::uint32_t least = kLeastCuringLevel;  ///< that cures by itself, and that whoever reads the mask takes for white
  std::uint32_t most_alone = kFullLevel;    ///< of a pixel that is to cure with the next layer's light only
};

/// Walks over the rays that enter in a layer, or so little above it that the next one would be too high, and over those of which it is the last.
class ChangingRays {
 public:
  /// @param section  of the layer
  ChangingRays(const RRep& rrep, std::uint32_t layer, ConstBitImage section, const EnteringLevels& levels);

  /// Goes to the next one, in ascending order of pixels.
  /// @returns false: there is none, and pixel() is kNone
  bool next();
  static constexpr std::uint32_t kNone = UINT32_MAX;
  std::uint32_t pixel() const { return pixel_; }
  bool is_lit() const { return is_lit_; }  ///< the section's bit; else the ray enters above the layer's sampling height
  std::uint8_t level() const { return level_; }  ///< of the layer's light, 0 to 255
  bool ends() const { return ends_; }            ///< the ray is lit, and not in the next layer

 private:
  std::uint32_t columns_;
  CrossingPacking packing_;
  ConstBitImage section_;
  const EnteringLevels* levels_;
  std::span<const std::uint32_t> own_, above_;  ///< crossings that are left, of the layer and of the next one
  std::uint32_t pixel_ = kNone;
  bool is_lit_ = false;
  std::uint8_t level_ = 0;
  bool ends_ = false;
};

}  // namespace plumbline::inline slicer
