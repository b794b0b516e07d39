#pragma once
/// Grey pixels where a wall passes through them, and where rays enter the object: from four rays around the middle one of each pixel.

#include <array>
#include <cstdint>
#include <optional>

#include "slicer/core/arena.hpp"
#include "slicer/core/bit_image.hpp"
#include "slicer/core/error.hpp"
#include "slicer/core/grey_runs.hpp"
#include "slicer/core/resin/cure_model.hpp"
#include "slicer/layers/layer_stream.hpp"
#include "slicer/rrep/rrep.hpp"
#include "slicer/supports/drawing/entering_levels.hpp"
#include "slicer/supports/drawing/support_cover.hpp"

namespace plumbline::inline slicer {

/// Finds the grey pixels of masks. A pixel's level is the mean of its four outer rays': white or black as their masks say, and as in VerticalGrey where
/// a ray enters between two layers' heights. Only pixels are looked at that have both white and black ones in the 3 x 3 around them in ray 0's mask, or where ray 0
/// enters: what was removed from that mask, such as specks, does not come back. Where more than half of a pixel's lit rays end, it is as ray 0's mask
/// has it: grey on tops makes skins that hang on nothing below. A pixel of ray 0's mask cures by its own light, and one that is not in it and cures is beside one that
/// is: what the checks of that mask have found holds. Supports are white, bottom and faded layers of one bit.
class FullGrey {
 public:
  /// @param rrep, supports    of the print, with other_rays(); must outlive this
  /// @param layer_height_mm   by which the plate moves
  /// @retval ErrorCode::kOutOfMemory  no room for bytes_needed() at the bottom of the arena
  [[nodiscard]] static Expected<FullGrey> create(const RRep& rrep, const Supports& supports, const CureModel& model,
                                                 double layer_height_mm, Arena& arena);
  static std::size_t bytes_needed(const PrintGrid& grid, std::size_t supports) {
    return SupportCover::bytes_needed(grid, supports) + kRaysAround * LayerStream::bytes_needed(grid);
  }

  /// @param section, mask  of the layer, of ray 0: MaskStream's, asked for it last
  /// @param image          a copy of the mask; gets the bits of the pixels' levels
  /// @param greys          overwritten
  void find(std::uint32_t layer, ConstBitImage section, ConstBitImage mask, BitImage image, GreyRuns& greys);

 private:
  FullGrey(const RRep& rrep, const CureModel& model, double layer_height_mm, const SupportCover& supports);

  struct Ray;
  struct Layer;
  struct Word;
  Word take_word(Ray& ray, std::uint32_t row, std::uint32_t word, std::uint32_t begin, std::uint32_t end) const;
  void find_in_word(Layer& layer, std::uint32_t row, std::uint32_t word);

  const RRep* rrep_;
  CrossingPacking packing_;
  std::uint32_t first_;  ///< layer
  EnteringLevels levels_;
  SupportCover supports_;
  std::array<std::optional<LayerStream>, kRaysAround> others_;
  std::uint32_t top_, bottom_, left_, right_;  ///< rows, and words of them, that the rays reach
};

}  // namespace plumbline::inline slicer
