#pragma once
/// The light that a layer gets through one mask after another.

#include <cstddef>
#include <cstdint>
#include <span>
#include <vector>

#include "hal/units.hpp"
#include "slicer/core/bit_image.hpp"
#include "slicer/core/grey_runs.hpp"

namespace plumbline::inline hal::inline sim {

/// Doses of one height, which add up pixel by pixel: nothing moves between them.
class LayerLight {
 public:
  LayerLight(std::uint32_t columns, std::uint32_t rows) : columns_(columns), rows_(rows) {}

  /// Begins a layer without light.
  void clear() { count_ = 0; }
  /// Adds light of `dose` through a mask.
  /// @param greys  ascending: pixels that get their level of the dose, whatever their bits say
  /// @returns whether no light came through this mask before
  bool add(ConstBitImage mask, std::span<const GreyRun> greys, Dose dose);
  /// What one mask would have to be so that all light through it gave each pixel what it got.
  /// @param bits   overwritten: the pixels that got light, but for those of `greys`, whose bits mean nothing
  /// @param greys  overwritten: the pixels that got a part of the light, rounded to levels
  void combine(BitImage bits, std::vector<GreyRun>& greys) const;

 private:
  struct Light {
    Dose dose;
    std::vector<std::uint64_t> bits;
    std::vector<GreyRun> greys;
  };
  std::span<const Light> lights() const { return std::span(lights_).first(count_); }
  void combine_row(std::uint32_t row, double dose, BitImage bits, std::vector<GreyRun>& greys) const;

  std::uint32_t columns_, rows_;
  std::vector<Light> lights_;  ///< no two of the same mask; those from `count_` on are kept for their memory
  std::size_t count_ = 0;
};

}  // namespace plumbline::inline hal::inline sim
