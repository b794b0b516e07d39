#pragma once
/// Draws the masks of a print into the panel's buffer, one for each exposure of a layer.

#include <chrono>
#include <cstdint>
#include <optional>
#include <span>

#include "firmware/print/job/layer_exposures.hpp"
#include "firmware/print/job/mask_source.hpp"
#include "firmware/print/job/print_plan.hpp"
#include "slicer/core/arena.hpp"
#include "slicer/core/bit_image.hpp"

namespace plumbline::firmware {

/// One mask's facts. Times are the processor's: the machine's clock may be virtual.
struct MaskFacts {
  std::uint64_t hash = 0;      ///< mask_hash() of the layer's own mask, with its greys
  std::uint64_t pixels = 0;    ///< of that mask that let light through, once for each PrintPlan::layer_height of height
  std::uint32_t exposure = 0;  ///< of the layer's, from 0
  bool is_last = true;         ///< exposure of the layer
  std::chrono::nanoseconds begin{};    ///< light that the layer has had when the exposure begins,
  std::chrono::nanoseconds end{};      ///< and ends
  std::chrono::nanoseconds making{};   ///< in its source, and of what differs from the layer's own
  std::chrono::nanoseconds copying{};  ///< into the panel's buffer
};

class MaskRenderer {
 public:
  /// Takes three rows from the bottom of the arena.
  /// @param source  must outlive the renderer
  /// @retval ErrorCode::kOutOfMemory
  [[nodiscard]] static Expected<MaskRenderer> create(MaskSource& source, const PrintPlan& plan, Arena& arena);

  static std::size_t bytes_needed(const PrintGrid& grid);

  const PrintGrid& grid() const { return source_->grid(); }

  /// Draws the mask that a layer needs when it has had `lit` of its light. Layers in ascending order cost least; the masks of one layer cost
  /// its source nothing but the first time, if it gives nobody else a mask meanwhile.
  /// @param out    of the grid's columns and rows; every word is written
  /// @param greys  empty: gets the grey pixels of the mask, whose bits in `out` follow their levels. None if it has no room
  /// @retval any error of the source
  [[nodiscard]] Expected<MaskFacts> render(std::uint32_t layer, std::chrono::nanoseconds lit, BitImage out,
                                           GreyRuns& greys);

  /// The layer's own mask, whose bits follow the levels of grey pixels. @pre render() has drawn one of its masks last
  ConstBitImage mask() const { return mask_; }

 private:
  MaskRenderer(MaskSource& source, const PrintPlan& plan, std::span<std::uint64_t> rows)
      : source_(&source), plan_(plan), rows_(rows) {}

  Status make(std::uint32_t layer);
  std::uint32_t strips_with_pixels() const;
  void show_shares(const LayerExposure& exposure, std::uint32_t n, BitImage out) const;

  MaskSource* source_;
  PrintPlan plan_;
  std::span<std::uint64_t> rows_;       ///< three rows of scratch
  std::optional<std::uint32_t> layer_;  ///< that was made last; and of it:
  ConstBitImage mask_;
  MaskNeeds needs_;
  std::uint32_t foot_steps_ = 0;
  std::uint64_t hash_ = 0, pixels_ = 0;
};

/// Takes `steps` pixels off the outline. Odd and even steps test 4 and 8 neighbours, so that what is removed is nearly a disc.
/// Pixels outside the image count as black.
/// @param scratch  3 rows of the image's stride
void erode(BitImage image, std::uint32_t steps, std::span<std::uint64_t> scratch);

}  // namespace plumbline::firmware
