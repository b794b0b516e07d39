#pragma once
/// The printed part: what was cured at each height.

#include <cstdint>
#include <functional>
#include <span>
#include <vector>

#include "hal/clock.hpp"
#include "hal/sim/plant/resin.hpp"
#include "hal/units.hpp"
#include "slicer/core/bit_image.hpp"

namespace plumbline {

/// All light at one height of the plate.
struct CuredLayer {
  ZPosition z;                  ///< of the plate; the layer fills the gap between the film and the layer above
  TimePoint began;              ///< first light
  TimePoint ended;              ///< last light
  std::uint32_t exposures = 0;  ///< more than one if an exposure was interrupted
  Dose asked;                   ///< for the first exposure; 0: unrequested light
  Dose dose;                    ///< of all exposures
  std::uint64_t pixels = 0;     ///< that got light
  double depth_mm = 0;          ///< cured depth; 0: nothing cured
};

/// Keeps each layer packed as its difference from the one before: a print of hundreds of megapixels takes some tens of megabytes.
class CuredPart {
 public:
  /// @param keep  false: keep no pixels, only doses and areas
  CuredPart(std::uint32_t columns, std::uint32_t rows, bool keep);

  /// Adds light of `dose` through `mask`. At the last layer's height (within 1 um) it belongs to that layer, elsewhere it starts a new
  /// one.
  void expose(ZPosition z, ConstBitImage mask, TimePoint began, TimePoint ended, Dose asked, Dose dose,
              const Resin& resin);

  /// The layer to which light at `z` would belong: the last one or the next.
  std::uint32_t layer_at(ZPosition z) const;

  std::span<const CuredLayer> layers() const { return layers_; }
  std::uint32_t columns() const { return columns_; }
  std::uint32_t rows() const { return rows_; }
  std::size_t packed_bytes() const { return packed_.size(); }

  /// Visits all layers from the plate on, with their cured pixels. The image is valid until `visit` returns. @pre keep
  void for_each_layer(const std::function<void(const CuredLayer&, ConstBitImage)>& visit) const;

 private:
  void pack_open_layer();

  std::uint32_t columns_;
  std::uint32_t rows_;
  bool keep_;
  std::vector<CuredLayer> layers_;
  std::vector<std::uint64_t> open_;    ///< mask of the last layer, which is not packed yet
  std::vector<std::uint64_t> before_;  ///< mask of the layer before
  std::vector<std::uint8_t> packed_;   ///< see pack_open_layer()
};

}  // namespace plumbline
