#pragma once
/// The grey pixels of a job's masks, beside the stream that makes these.

#include <cstddef>
#include <cstdint>
#include <optional>
#include <span>

#include "slicer/core/arena.hpp"
#include "slicer/core/bit_image.hpp"
#include "slicer/core/error.hpp"
#include "slicer/core/grey_runs.hpp"
#include "slicer/core/print_grid.hpp"
#include "slicer/core/resin/cure_model.hpp"
#include "slicer/rrep/rrep.hpp"
#include "slicer/supports/drawing/full_grey.hpp"
#include "slicer/supports/drawing/mask_stream.hpp"
#include "slicer/supports/drawing/supports.hpp"
#include "slicer/supports/drawing/vertical_grey.hpp"

namespace plumbline::inline slicer {

/// Those of FullGrey if each pixel has four rays, else those of VerticalGrey.
class GreyMasks {
 public:
  /// Takes bytes_needed() from the bottom of the arena.
  /// @param layer_height_mm  of the machine
  /// @retval ErrorCode::kOutOfMemory
  [[nodiscard]] static Expected<GreyMasks> create(const RRep& rrep, const Supports& supports, const CureModel& model,
                                                  double layer_height_mm, Arena& arena);
  /// @param grey  0 bytes if it is off
  static std::size_t bytes_needed(const PrintGrid& grid, std::size_t supports, Grey grey);

  /// @param mask  the stream's for `layer`, asked for last
  /// @returns the mask as it is printed and hashed: the bits of grey pixels follow their levels. A view, valid until the next call and
  ///          as long as `mask`
  ConstBitImage find(std::uint32_t layer, const MaskStream& stream, ConstBitImage mask);
  /// Of the mask that was found last.
  std::span<const GreyRun> greys() const { return greys_.runs(); }

 private:
  GreyMasks(const GreyRuns& greys, BitImage image) : greys_(greys), image_(image) {}

  std::optional<VerticalGrey> vertical_;  ///< one of these
  std::optional<FullGrey> full_;
  GreyRuns greys_;
  BitImage image_;
};

}  // namespace plumbline::inline slicer
