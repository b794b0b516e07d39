#pragma once
/// Masks for the panel: the layer stream's, with the outline of the bottom layers drawn in, in the panel's buffer.

#include <chrono>
#include <cstdint>
#include <span>

#include "firmware/print/print_plan.hpp"
#include "slicer/core/arena.hpp"
#include "slicer/core/bit_image.hpp"
#include "slicer/layers/layer_stream.hpp"

namespace plumbline {

/// What a mask took, by the processor's clock: the machine's may be virtual.
struct MaskFacts {
  std::uint64_t hash = 0;              ///< mask_hash()
  std::uint64_t pixels = 0;            ///< that let light through
  std::chrono::nanoseconds making{};   ///< the layer stream's part
  std::chrono::nanoseconds copying{};  ///< its bytes into the panel's buffer
};

class MaskMaker {
 public:
  /// Takes a few rows from the bottom of the arena.
  /// @param stream  outlives the maker
  /// @retval ErrorCode::kOutOfMemory
  [[nodiscard]] static Expected<MaskMaker> create(LayerStream& stream, const PrintPlan& plan, Arena& arena);

  static std::size_t bytes_needed(const PrintGrid& grid);

  const PrintGrid& grid() const { return stream_->grid(); }

  /// Draws the mask of a layer; every word of `out` is written. The layer after the last one costs least.
  /// @param out  of the grid's columns and rows
  MaskFacts make(std::uint32_t layer, BitImage out);

 private:
  MaskMaker(LayerStream& stream, const PrintPlan& plan, std::span<std::uint64_t> rows)
      : stream_(&stream), plan_(plan), rows_(rows) {}

  LayerStream* stream_;
  PrintPlan plan_;
  std::span<std::uint64_t> rows_;  ///< three rows of scratch
};

/// Takes `steps` pixels off the outline, by turns from the 4 and the 8 neighbours of each pixel, so that what goes is nearly a
/// disc. Outside of the image all is black.
/// @param scratch  3 rows of the image's stride
void erode(BitImage image, std::uint32_t steps, std::span<std::uint64_t> scratch);

}  // namespace plumbline
