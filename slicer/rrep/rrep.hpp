#pragma once
/// The ray representation of the object, kept until the print ends.

#include <algorithm>
#include <bit>
#include <cstdint>
#include <span>

#include "slicer/core/bit_image.hpp"
#include "slicer/core/print_grid.hpp"

namespace plumbline::inline slicer {

/// Height of a crossing on its ray. Layer k has those in ((k - 1/2) layer_height, (k + 1/2) layer_height], the first also those below:
/// it is the first layer whose sampling height is not below the crossing.
class CrossingHeight {
 public:
  static constexpr unsigned kBits = 8;
  static constexpr std::uint32_t kParts = 1U << kBits;     ///< of a layer height
  static constexpr std::uint32_t kUnderside = kParts / 2;  ///< the part at the layer's underside, k layer_height

  constexpr CrossingHeight() = default;
  /// @param part  counted upwards, 0 to kParts - 1
  constexpr explicit CrossingHeight(std::uint32_t layer, std::uint32_t part = kUnderside)
      : value_(layer << kBits | part) {}

  constexpr std::uint32_t layer() const { return value_ >> kBits; }
  constexpr std::uint32_t part() const { return value_ % kParts; }
  /// The part where there is room for fewer bits, and the middle of what that stands for.
  constexpr std::uint32_t part(unsigned bits) const { return part() >> (kBits - bits); }
  static constexpr std::uint32_t part_of(std::uint32_t shortened, unsigned bits) {
    return (2 * shortened + 1) << (kBits - bits) >> 1U;
  }

 private:
  std::uint32_t value_ = 0;
};

/// @param depth  mm; below 0 counts as layer 0
/// @returns layers 0 to grid.layers; grid.layers means above all sampling heights
CrossingHeight height_of(float depth, const PrintGrid& grid);

/// Packs a crossing in 32 bits: the number of its pixel, row * columns + column, and below it as much of its height within the layer as there is
/// room for: 8 bits on panels of up to 4K, 7 at 8K.
class CrossingPacking {
 public:
  explicit constexpr CrossingPacking(const PrintGrid& grid)
      : bits_(std::min(CrossingHeight::kBits,
                       static_cast<unsigned>(std::countl_zero(std::max(1U, grid.columns * grid.rows) - 1U)))) {}

  constexpr std::uint32_t packed(std::uint32_t pixel, std::uint32_t part = CrossingHeight::kUnderside) const {
    return pixel << bits_ | part >> (CrossingHeight::kBits - bits_);
  }
  constexpr std::uint32_t pixel(std::uint32_t packed) const { return packed >> bits_; }
  /// @param layer  of the crossing
  constexpr CrossingHeight height(std::uint32_t packed, std::uint32_t layer) const {
    return CrossingHeight(layer, (2 * (packed % (1U << bits_)) + 1) << (CrossingHeight::kBits - bits_) >> 1U);
  }
  /// Above the plate, mm, to half a part.
  float height_mm(std::uint32_t packed, std::uint32_t layer, const PrintGrid& grid) const {
    const float part = (static_cast<float>(packed % (1U << bits_)) + 0.5F) / static_cast<float>(1U << bits_);
    return (static_cast<float>(layer) - 0.5F + part) * grid.layer_height_mm;
  }

 private:
  unsigned bits_;  ///< of a height
};

/// Crossings of all rays with the surface, sorted by layer (thesis III-1, LDNI without normals).
///
/// After repair every ray alternates entering and exiting, so one crossing toggles its pixel: the mask of layer k is the
/// mask of layer k - 1 with the pixels of packed[first[k]] ... packed[first[k + 1] - 1] toggled. The mask before layer 0 is
/// black. Crossings of one ray that are of the same layer (CrossingHeight) have cancelled in pairs. All memory is the arena's.
struct RRep {
  PrintGrid grid;
  std::span<const std::uint32_t> first;   ///< layers + 1 entries
  std::span<const std::uint32_t> packed;  ///< by CrossingPacking; pixels ascend within a layer, none twice in one
  bool is_exact = false;                  ///< of a mesh: a layer's mask is its section, not opened and closed
  /// The other rays of each pixel, with_ray() 1 to kRaysAround, if it has them: this is ray 0. They have the same layers, and less has been
  /// removed from them: what is not beside a pixel of this one's masks belongs to no mask.
  RRep* others = nullptr;

  std::size_t crossings() const { return packed.size(); }
  std::span<RRep> other_rays() const { return {others, others == nullptr ? 0U : kRaysAround}; }
};

}  // namespace plumbline::inline slicer
