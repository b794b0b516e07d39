#pragma once
/// Where the masks of a print come from.

#include <cstdint>

#include "slicer/core/bit_image.hpp"
#include "slicer/core/error.hpp"
#include "slicer/core/print_grid.hpp"
#include "slicer/supports/drawing/mask_stream.hpp"

namespace plumbline {

class MaskSource {
 public:
  virtual ~MaskSource() = default;
  virtual const PrintGrid& grid() const = 0;
  /// The mask of a layer. Layers in ascending order cost least.
  /// @param layer  below grid().layers
  /// @returns a view, valid until the next call
  [[nodiscard]] virtual Expected<ConstBitImage> mask(std::uint32_t layer) = 0;
};

/// The masks of an R-Rep.
class StreamMasks final : public MaskSource {
 public:
  explicit StreamMasks(const MaskStream& stream) : stream_(stream) {}
  const PrintGrid& grid() const override { return stream_.grid(); }
  Expected<ConstBitImage> mask(std::uint32_t layer) override { return stream_.mask(layer); }

 private:
  MaskStream stream_;
};

}  // namespace plumbline
