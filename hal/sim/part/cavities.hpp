#pragma once
/// Resin that the part encloses: suction cups and traps.

#include <cstdint>
#include <vector>

#include "hal/sim/part/part_regions.hpp"
#include "slicer/core/resin/peel_force.hpp"

namespace plumbline::inline hal::inline sim {

/// Follows the black regions of the layers from the plate on. Regions that lie above each other are one cavity. A cavity is
/// *vented* once it meets the outside in any layer; until then it is *sealed*, by the part or by the plate. A sealed cavity that
/// reaches the newest layer is a suction cup. One that ends is a trap, unless the plate is its ceiling: that one drains when the
/// part comes off. What sucks in a cup pulls at its ceiling, so the plate carries its share of that.
class Cavities {
 public:
  /// Largest of the traps.
  struct Trap {
    std::uint32_t layer = 0;  ///< its last one
    double mm3 = 0;
  };

  /// Takes the next layer.
  /// @param before     the layer before
  /// @param first      it is on the plate
  /// @param pixel_mm3  volume of a pixel in it
  void next_layer(const PartRegions& before, const PartRegions& here, bool first, std::uint32_t layer,
                  double pixel_mm3);
  /// Whether a black region of the last layer is the mouth of a sealed cavity.
  bool sealed(std::uint32_t region) const { return region > 0 && !cavities_[of_region_[region]].vented; }
  bool any() const { return !cavities_.empty(); }
  /// Of the mouths of a sealed cavity, the share below which the ceiling is part, not plate. 0: the plate is as wide as they are.
  /// @param region  sealed
  double share_of_part(std::uint32_t region) const {
    const Cavity& cavity = cavities_[of_region_[region]];
    return PeelSettings::share_of_part(cavity.plate_pixels, cavity.mouth_pixels);
  }

  double trapped_mm3() const { return trapped_mm3_; }
  std::uint32_t traps() const { return traps_; }
  const Trap& largest_trap() const { return largest_; }

 private:
  struct Cavity {
    bool vented = false;
    bool on_plate = false;
    std::uint64_t plate_pixels = 0;  ///< of its ceiling that are plate
    std::uint64_t mouth_pixels = 0;  ///< in the last layer
    double mm3 = 0;
  };

  std::vector<Cavity> cavities_;          ///< that reach the last layer
  std::vector<std::uint32_t> of_region_;  ///< cavity of each black region of the last layer; none for the outside
  std::vector<std::uint32_t> parents_;
  double trapped_mm3_ = 0;
  std::uint32_t traps_ = 0;
  Trap largest_;
};

}  // namespace plumbline::inline hal::inline sim
