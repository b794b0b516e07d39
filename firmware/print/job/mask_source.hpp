#pragma once
/// Where the masks of a print come from.

#include <cstdint>
#include <optional>
#include <span>
#include <string>

#include "firmware/archive/layer_archive.hpp"
#include "slicer/core/arena.hpp"
#include "slicer/core/bit_image.hpp"
#include "slicer/core/error.hpp"
#include "slicer/core/grey_runs.hpp"
#include "slicer/core/print_grid.hpp"
#include "slicer/supports/drawing/grey_masks.hpp"
#include "slicer/supports/drawing/mask_stream.hpp"

namespace plumbline::firmware {

class MaskSource {
 public:
  virtual ~MaskSource() = default;
  virtual const PrintGrid& grid() const = 0;
  /// The mask of a layer. Layers in ascending order cost least.
  /// @param layer  below grid().layers
  /// @returns a view, valid until the next call
  [[nodiscard]] virtual Expected<ConstBitImage> mask(std::uint32_t layer) = 0;
  /// The grey pixels of the mask that was given last, valid as long as that.
  virtual std::span<const GreyRun> greys() const { return {}; }
};

/// The masks of an R-Rep.
class StreamMasks final : public MaskSource {
 public:
  explicit StreamMasks(const MaskStream& stream, const LayerSteps& steps = {})
      : stream_(stream), grid_(stream.grid()), steps_(steps) {
    grid_.layers = steps.layers(grid_.layers);
  }
  /// Takes what it needs from the bottom of the arena.
  /// @param grey             if it is known, masks have grey pixels where rays enter the object
  /// @param layer_height_mm  of the R-Rep
  /// @param steps            heights of the print's layers
  /// @retval ErrorCode::kOutOfMemory
  [[nodiscard]] static Expected<StreamMasks> create(const RRep& rrep, const Supports& supports, const CureModel& grey,
                                                    double layer_height_mm, Arena& arena, const LayerSteps& steps = {});

  /// Counts the print's layers; the layer height is still the R-Rep's.
  const PrintGrid& grid() const override { return grid_; }
  Expected<ConstBitImage> mask(std::uint32_t layer) override;
  /// The object's part of the mask that was given last, before opening, closing and supports.
  ConstBitImage section() const { return stream_.section(); }
  std::span<const GreyRun> greys() const override { return grey_ ? grey_->greys() : std::span<const GreyRun>(); }

 private:
  MaskStream stream_;
  PrintGrid grid_;
  LayerSteps steps_;
  std::optional<GreyMasks> grey_;
};

/// Decodes a layer of an archive.
class LayerDecoder {
 public:
  virtual ~LayerDecoder() = default;
  /// Called once before the first decode() of a print.
  /// @param shows_grey  the panel does, so decode() is asked for greys
  /// @param arena       what it needs is taken from the top
  [[nodiscard]] virtual Status prepare(const PrintGrid& /*grid*/, bool /*shows_grey*/, Arena& /*arena*/) { return {}; }
  /// @param file   the archive's descriptor
  /// @param out    overwritten, also after an error
  /// @param greys  becomes the grey pixels of `out`, as many as it has room for
  /// @retval any error of read_archive_layer()
  [[nodiscard]] virtual Status decode(int file, std::string_view name, const ArchiveLayer& layer, const MaskTurn& turn,
                                      BitImage out, GreyRuns& greys) = 0;
};

/// In this process.
class OwnLayerDecoder final : public LayerDecoder {
 public:
  Status decode(int file, std::string_view name, const ArchiveLayer& layer, const MaskTurn& turn, BitImage out,
                GreyRuns& greys) override {
    return read_archive_layer(file, name, layer, turn, out, &greys);
  }
};

/// Room for the grey pixels of a mask, at the bottom of the arena; none if the panel shows none.
/// @retval ErrorCode::kOutOfMemory
[[nodiscard]] Expected<GreyRuns> take_greys(const PrintGrid& grid, bool shows_grey, Arena& arena);

class ArchiveMasks final : public MaskSource {
 public:
  /// Takes a mask from the bottom of the arena, and room for its greys.
  /// @param file        a descriptor; must stay open
  /// @param layers      with their hashes; must outlive this, as must the decoder
  /// @param shows_grey  the panel does, as it did when the layers were hashed
  /// @retval ErrorCode::kOutOfMemory
  [[nodiscard]] static Expected<ArchiveMasks> create(int file, std::string_view name, const PrintGrid& grid,
                                                     std::span<const ArchiveLayer> layers, const MaskTurn& turn,
                                                     LayerDecoder& decoder, bool shows_grey, Arena& arena);

  const PrintGrid& grid() const override { return grid_; }
  /// @retval any error of the decoder
  /// @retval ErrorCode::kMalformed  the mask is not the one that was checked
  Expected<ConstBitImage> mask(std::uint32_t layer) override;
  std::span<const GreyRun> greys() const override { return greys_.runs(); }

 private:
  ArchiveMasks(int file, std::string_view name, const PrintGrid& grid, std::span<const ArchiveLayer> layers,
               const MaskTurn& turn, LayerDecoder& decoder, BitImage image, const GreyRuns& greys)
      : file_(file),
        name_(name),
        grid_(grid),
        layers_(layers),
        turn_(turn),
        decoder_(&decoder),
        image_(image),
        greys_(greys) {}

  int file_;
  std::string name_;
  PrintGrid grid_;
  std::span<const ArchiveLayer> layers_;
  MaskTurn turn_;
  LayerDecoder* decoder_;
  BitImage image_;
  GreyRuns greys_;
};

}  // namespace plumbline::firmware
