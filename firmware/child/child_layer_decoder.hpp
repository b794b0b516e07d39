#pragma once
/// Decodes an archive's layers during a print, each in a child of its own without rights.

#include <chrono>
#include <optional>

#include "firmware/child/slicing_child.hpp"
#include "firmware/print/archive_masks.hpp"
#include "slicer/placement/placement.hpp"

namespace plumbline {

class ChildLayerDecoder final : public LayerDecoder {
 public:
  /// A layer of the largest panel takes a Cortex-A53 a second or two. A child that takes this long is killed.
  static constexpr std::chrono::seconds kPatience{30};

  /// @param child    must outlive this
  /// @param printer  whose panel the masks are for
  ChildLayerDecoder(SlicingChild& child, const PrinterVolume& printer) : child_(child), printer_(printer) {}

  /// Takes a mask and up to two pages from the top of the arena that the child shares.
  Status prepare(const PrintGrid& grid, Arena& arena) override;
  /// @retval ErrorCode::kMalformed      also if the child crashed or hung
  /// @retval ErrorCode::kDeviceTimeout  no child can be started any more
  Status decode(int file, std::string_view name, const ArchiveLayer& layer, const MaskTurn& turn,
                BitImage out) override;

 private:
  SlicingChild& child_;
  PrinterVolume printer_;
  std::span<std::byte> mask_;  ///< on a page
};

}  // namespace plumbline
