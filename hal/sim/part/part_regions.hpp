#pragma once
/// The regions of one layer of the part, numbered.

#include <cstdint>
#include <span>
#include <vector>

#include "slicer/core/bit_image.hpp"
#include "slicer/core/bit_spans.hpp"
#include "slicer/core/regions/layer_regions.hpp"
#include "slicer/core/regions/region_shapes.hpp"

namespace plumbline::inline hal::inline sim {

/// LayerRegions with as much memory as the layer needs. White regions are numbered from 0, enclosed black ones from 1; black 0 is the
/// outside. Pixels are joined at sides.
class PartRegions {
 public:
  PartRegions() = default;
  PartRegions(PartRegions&&) = default;
  PartRegions& operator=(PartRegions&&) = default;

  void find(ConstBitImage image);

  const LayerRegions& runs() const { return regions_; }
  std::span<const RegionShape> white() const { return white_; }
  std::span<const std::uint32_t> black() const { return black_; }  ///< names in runs()
  std::uint32_t number(std::uint32_t name) const { return number_[name]; }
  std::uint32_t pixels(const RegionShape& shape) const { return regions_.area(shape.region); }
  /// Number of the region of a pixel.
  std::uint32_t number_at(std::uint32_t column, std::uint32_t row) const {
    return number_[regions_.region(regions_.run_at(column, row))];
  }
  /// Fills the white regions for which which(number) is true.
  template <class Which>
  void fill(BitImage image, bool white, Which which) const {
    regions_.for_each_white_run([&](std::uint32_t row, std::uint32_t i) {
      const LayerRegions::Run& run = regions_.run(i);
      if (which(number_[regions_.region(i)])) plumbline::fill(image, row, run.first, run.last + 1U, white);
    });
  }

 private:
  std::vector<std::byte> memory_;
  LayerRegions regions_;
  std::vector<std::uint32_t> number_;  ///< of a region of regions_
  std::vector<RegionShape> white_;
  std::vector<std::uint32_t> black_;
};

/// Calls use(a, b, pixels) for each pair of runs of one colour, of two layers, that lie above each other in `pixels` > 0 pixels.
/// @param use  gets the numbers of their regions
template <class Use>
void for_each_contact(const PartRegions& a, const PartRegions& b, bool white, Use use) {
  for (std::uint32_t r = 0; r < a.runs().rows(); ++r) {
    for_each_contact_in_row(a.runs(), b.runs(), r, white, [&](const RegionContact& contact) {
      use(a.number(contact.below), b.number(contact.above), contact.pixels);
    });
  }
}

}  // namespace plumbline::inline hal::inline sim
