#pragma once
/// Draws the layer stream's masks into the panel's buffer, with the bottom layers' outlines moved inwards against elephant's foot.

#include <chrono>
#include <cstdint>
#include <span>

#include "firmware/print/plan/print_plan.hpp"
#include "slicer/core/arena.hpp"
#include "slicer/core/bit_image.hpp"
#include "slicer/supports/drawing/mask_stream.hpp"

namespace plumbline {

/// One mask's facts. Times are the processor's: the machine's clock may be virtual.
struct MaskFacts {
  std::uint64_t hash = 0;              ///< mask_hash()
  std::uint64_t pixels = 0;            ///< that let light through
  std::chrono::nanoseconds making{};   ///< in the layer stream, and eroding
  std::chrono::nanoseconds copying{};  ///< into the panel's buffer
};

class MaskRenderer {
 public:
  /// Takes three rows from the bottom of the arena.
  /// @param stream  must outlive the renderer
  /// @retval ErrorCode::kOutOfMemory
  [[nodiscard]] static Expected<MaskRenderer> create(MaskStream& stream, const PrintPlan& plan, Arena& arena);

  static std::size_t bytes_needed(const PrintGrid& grid);

  const PrintGrid& grid() const { return stream_->grid(); }

  /// Draws the mask of a layer. Layers in ascending order cost least.
  /// @param out  of the grid's columns and rows; every word is written
  MaskFacts render(std::uint32_t layer, BitImage out);

 private:
  MaskRenderer(MaskStream& stream, const PrintPlan& plan, std::span<std::uint64_t> rows)
      : stream_(&stream), plan_(plan), rows_(rows) {}

  MaskStream* stream_;
  PrintPlan plan_;
  std::span<std::uint64_t> rows_;  ///< three rows of scratch
};

/// Takes `steps` pixels off the outline. Odd and even steps test 4 and 8 neighbours, so that what is removed is nearly a disc.
/// Pixels outside the image count as black.
/// @param scratch  3 rows of the image's stride
void erode(BitImage image, std::uint32_t steps, std::span<std::uint64_t> scratch);

}  // namespace plumbline
