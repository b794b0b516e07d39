#pragma once
/// A print that somebody else has sliced, looked through before it is printed.

#include <cstddef>
#include <cstdint>
#include <span>
#include <string_view>

#include "firmware/archive/layer_archive.hpp"
#include "firmware/settings/print_profile.hpp"
#include "slicer/checks/stack_findings.hpp"
#include "slicer/core/arena.hpp"
#include "slicer/core/bit_image.hpp"
#include "slicer/core/function_ref.hpp"
#include "slicer/core/print_grid.hpp"
#include "slicer/core/progress.hpp"
#include "slicer/placement/placement.hpp"
#include "slicer/rrep/mask_extent.hpp"
#include "slicer/rrep/rrep.hpp"

namespace plumbline::firmware {

struct SlicedArchive {
  PrintGrid grid;
  std::span<const ArchiveLayer> layers;  ///< with their hashes, at the bottom of the arena
  std::size_t layers_end = 0;            ///< the arena's bottom mark above them
  MaskTurn turn;
  bool turned = false;  ///< by 90 degrees, to fit the panel
  GreyShare grey;       ///< of all layers
  ArchiveSettings settings;
  MaskExtent extent;
  StackFindings findings;  ///< of its masks
  RRep rrep;               ///< for pictures, above `layers` in the arena; empty: there was no room for it
};

/// The printer that an archive has to fit.
struct ArchiveTarget {
  PrinterVolume printer;
  double layer_height_mm = 0;  ///< if the archive does not say
  PeelSettings peel;           ///< of the resin: for the checks
  bool shows_grey = false;     ///< the panel does: grey pixels are hashed, too
};

/// Whether an archive is for the printer's panel. One that lies across it is turned by 90 degrees.
/// @retval ErrorCode::kDoesNotFit  it has other pixels: how many there and here, or how large
[[nodiscard]] Status check_panel(LayerArchive& archive, std::string_view name, const PrinterVolume& printer);

/// Decodes every layer once, checks the masks, and hashes them. Pictures may be drawn before the arena is released down to `layers`.
/// @param file      the archive's descriptor
/// @param progress  may be null
/// @retval any error of LayerArchive and check_panel()
/// @retval ErrorCode::kCancelled, kOutOfMemory
[[nodiscard]] Expected<SlicedArchive> check_archive(int file, std::string_view name, const ArchiveTarget& target,
                                                    Arena& arena, ProgressSink* progress);

/// Visits each thing that people are told about an archive before it is printed, as a code and as an English sentence.
void for_each_remark(const SlicedArchive& sliced, FunctionRef<void(const Told&, std::string_view)> visit);

/// The profile with the archive's values, and above them what a person has said; without what the archive's slicer has done already.
/// @param name  of the archive, for messages
/// @retval ErrorCode::kBadSetting  the person asks for another layer height than that of the archive's masks
[[nodiscard]] Expected<PrintProfile> profile_of(const PrintProfile& printers, const ArchiveSettings& settings,
                                                std::string_view name, const PrintValues& by_person = {});

/// Collects the pixels that differ from the layer below, as long as there is room: an R-Rep, to draw masks that somebody else has made.
class LayerCrossings {
 public:
  /// Takes all that is left of the arena, from its bottom, except the room that the pictures need.
  static LayerCrossings make(const PrintGrid& grid, Arena& arena);

  /// @param layer  each layer of the grid, in order
  /// @param below  the mask before it; empty below the first
  void next(std::uint32_t layer, ConstBitImage mask, ConstBitImage below);
  /// @returns an empty one if there was no room for all
  RRep rrep(const PrintGrid& grid) const;

 private:
  std::span<std::uint32_t> first_, packed_;
  std::size_t count_ = 0;
  bool fits_ = false;
};

}  // namespace plumbline::firmware
