#pragma once
/// The printed part: what was cured at each height.

#include <cstdint>
#include <functional>
#include <span>
#include <vector>

#include "hal/clock.hpp"
#include "hal/sim/resin.hpp"
#include "hal/units.hpp"
#include "slicer/core/bit_image.hpp"

namespace plumbline {

/// All light that fell at one height of the plate.
struct CuredLayer {
  ZPosition z;                  ///< of the plate; the layer lies between the film and what was cured before
  TimePoint began;              ///< first light
  TimePoint ended;              ///< last light
  std::uint32_t exposures = 0;  ///< more than one where an exposure was interrupted
  Dose asked;                   ///< by the first exposure; 0: light came without having been asked for
  Dose dose;                    ///< of all of them
  std::uint64_t pixels = 0;     ///< that got light
  double depth_mm = 0;          ///< that they are cured; 0: none is
};

/// Keeps its layers packed, each as what it differs from the one below: a print of hundreds of megapixels takes some tens of
/// megabytes.
class CuredPart {
 public:
  /// @param keep  false: dimensions, doses and areas only
  CuredPart(std::uint32_t columns, std::uint32_t rows, bool keep);

  /// Light of `dose` through `mask`. The same height as last time (within a micrometre) goes on with that layer, another one
  /// begins the next.
  void expose(ZPosition z, ConstBitImage mask, TimePoint began, TimePoint ended, Dose asked, Dose dose,
              const Resin& resin);

  /// The layer that light at `z` would fall in: the last one or the next.
  std::uint32_t layer_at(ZPosition z) const;

  std::span<const CuredLayer> layers() const { return layers_; }
  std::uint32_t columns() const { return columns_; }
  std::uint32_t rows() const { return rows_; }
  std::size_t packed_bytes() const { return packed_.size(); }

  /// From the plate on, with the pixels that are cured. The image is valid until the visit returns. Not with keep == false.
  void for_each_layer(const std::function<void(const CuredLayer&, ConstBitImage)>& visit) const;

 private:
  void pack_open_layer();

  std::uint32_t columns_;
  std::uint32_t rows_;
  bool keep_;
  std::vector<CuredLayer> layers_;
  std::vector<std::uint64_t> open_;    ///< mask of the last layer, not packed yet
  std::vector<std::uint64_t> before_;  ///< mask of the layer before
  std::vector<std::uint8_t> packed_;   ///< see pack_open_layer()
};

}  // namespace plumbline
