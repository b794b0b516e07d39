#pragma once
/// The printed part: what was cured at each height and stayed.

#include <cstdint>
#include <functional>
#include <span>
#include <vector>

#include "hal/clock.hpp"
#include "hal/sim/part/hanging_part.hpp"
#include "hal/sim/part/layer_light.hpp"
#include "hal/sim/plant/resin.hpp"
#include "hal/units.hpp"
#include "slicer/core/bit_image.hpp"
#include "slicer/core/grey_runs.hpp"

namespace plumbline::inline hal::inline sim {

/// All light at one height of the plate.
struct CuredLayer {
  ZPosition z;                  ///< of the plate; the layer fills the gap between the film and the layer above
  TimePoint began;              ///< first light
  TimePoint ended;              ///< last light
  std::uint32_t exposures = 0;  ///< more than one if an exposure was interrupted, or through one mask after another
  Dose asked;                   ///< for the first exposure through each of its masks; 0: unrequested light
  Dose dose;                    ///< of all exposures
  std::uint64_t pixels = 0;     ///< that got light, whether or not they stayed
  double depth_mm = 0;          ///< cured depth; 0: nothing cured
  double height_mm = 0;         ///< of the gap that it fills; 0: it is not complete
};

/// Keeps each layer packed as its difference from the one before: a print of hundreds of megapixels takes some tens of megabytes.
class CuredPart {
 public:
  /// @param keep  false: keep no pixels, only doses and areas
  CuredPart(std::uint32_t columns, std::uint32_t rows, double pitch_x_mm, double pitch_y_mm, const PeelSettings& peel,
            bool keep);

  /// Adds light of `dose` through `mask`, except where something lies on the film. At the last layer's height (within 1 um) it
  /// belongs to that layer, elsewhere it starts a new one.
  /// @param greys  ascending: pixels that get their level of the dose. They cure where that is above the critical dose, whatever their bits
  ///               say. Exposures of one layer add up pixel by pixel: what lit only some of them becomes grey
  void expose(ZPosition z, ConstBitImage mask, TimePoint began, TimePoint ended, Dose asked, Dose dose,
              const Resin& resin, std::span<const GreyRun> greys = {});

  /// Judges the last layer, which has all its light: what drops, what the peel tears off.
  /// @param number     of the layer, for losses
  /// @param height_mm  of the gap that it fills
  /// @param on_part    it is the first one on a part that an earlier print left
  void complete_layer(std::uint32_t number, double height_mm, bool on_part);
  /// Whether the last layer is the first of a part: it is as close to the plate as the first of all. @pre there is a layer
  bool begins_a_part() const;
  HangingPart& hanging() { return hanging_; }
  const HangingPart& hanging() const { return hanging_; }

  /// The layer to which light at `z` would belong: the last one or the next.
  std::uint32_t layer_at(ZPosition z) const;

  std::span<const CuredLayer> layers() const { return layers_; }
  std::uint32_t columns() const { return columns_; }
  std::uint32_t rows() const { return rows_; }
  std::size_t packed_bytes() const { return packed_.size() + packed_greys_.size(); }

  /// Visits all layers from the plate on, with the cured pixels that stayed. The image is valid until `visit` returns. @pre keep
  void for_each_layer(const std::function<void(const CuredLayer&, ConstBitImage)>& visit) const;
  /// The same with the pixels that got a part of the dose; none in a layer that lost pixels.
  using LitVisit = std::function<void(const CuredLayer&, ConstBitImage, std::span<const GreyRun>)>;
  void for_each_lit_layer(const LitVisit& visit) const;

 private:
  void judge_greys(const Resin& resin);
  void pack_open_layer();
  void pack_open_greys();
  BitImage image(std::vector<std::uint64_t>& words) const { return {words, columns_, rows_}; }

  std::uint32_t columns_;
  std::uint32_t rows_;
  bool keep_;
  HangingPart hanging_;
  std::vector<CuredLayer> layers_;
  LayerLight light_;                        ///< of the last layer
  TimePoint began_;                         ///< the last light
  std::vector<std::uint64_t> open_;         ///< lit pixels of the last layer, which is not packed yet
  std::vector<std::uint64_t> asked_;        ///< with those in the shadow of what lies on the film; valid if `shaded_`
  bool shaded_ = false;                     ///< something lay on the film when the last layer began
  std::vector<std::uint64_t> before_;       ///< mask of the layer before
  std::vector<std::uint8_t> packed_;        ///< see pack_open_layer()
  std::vector<GreyRun> open_greys_;         ///< of the last layer
  std::vector<std::uint8_t> packed_greys_;  ///< see pack_open_greys()
};

}  // namespace plumbline::inline hal::inline sim
