#pragma once
/// Draws the masks of a print into the panel's buffer, with the bottom layers' outlines moved inwards against elephant's foot.

#include <chrono>
#include <cstdint>
#include <span>

#include "firmware/print/job/mask_source.hpp"
#include "firmware/print/job/print_plan.hpp"
#include "slicer/core/arena.hpp"
#include "slicer/core/bit_image.hpp"

namespace plumbline::firmware {

/// One mask's facts. Times are the processor's: the machine's clock may be virtual.
struct MaskFacts {
  std::uint64_t hash = 0;    ///< mask_hash()
  std::uint64_t pixels = 0;  ///< that let light through, times the layer's height in parts of PrintPlan::layer_height
  std::chrono::nanoseconds making{};   ///< in its source, and eroding
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

  /// Draws the mask of a layer. Layers in ascending order cost least.
  /// @param out    of the grid's columns and rows; every word is written
  /// @param greys  null, or empty: gets the grey pixels of the mask, whose bits in `out` follow their levels. A layer whose outline is moved
  ///               inwards has none
  /// @retval any error of the source
  [[nodiscard]] Expected<MaskFacts> render(std::uint32_t layer, BitImage out, GreyRuns* greys = nullptr);

 private:
  MaskRenderer(MaskSource& source, const PrintPlan& plan, std::span<std::uint64_t> rows)
      : source_(&source), plan_(plan), rows_(rows) {}

  MaskSource* source_;
  PrintPlan plan_;
  std::span<std::uint64_t> rows_;  ///< three rows of scratch
};

/// Takes `steps` pixels off the outline. Odd and even steps test 4 and 8 neighbours, so that what is removed is nearly a disc.
/// Pixels outside the image count as black.
/// @param scratch  3 rows of the image's stride
void erode(BitImage image, std::uint32_t steps, std::span<std::uint64_t> scratch);

}  // namespace plumbline::firmware
