#pragma once
/// Decodes an archive's layers during a print, each in a child of its own without rights.

#include <chrono>
#include <optional>

#include "firmware/child/slicing_child.hpp"
#include "firmware/print/job/mask_source.hpp"
#include "slicer/placement/placement.hpp"

namespace plumbline::firmware {

/// How long a layer may take.
struct LayerPatience {
  /// A layer of the largest panel takes a Cortex-A53 a second or two. A child that takes this long is killed.
  std::chrono::milliseconds layer = std::chrono::seconds(30);
  /// The same once the system has asked this program to end.
  std::chrono::milliseconds last = std::chrono::seconds(3);
  /// For a killed child to end: its archive is on the printer's own storage.
  std::chrono::milliseconds end = std::chrono::seconds(5);
};

class ChildLayerDecoder final : public LayerDecoder {
 public:
  /// @param child    must outlive this
  /// @param printer  whose panel the masks are for
  ChildLayerDecoder(SlicingChild& child, const PrinterVolume& printer, const LayerPatience& patience = {})
      : child_(child), printer_(printer), patience_(patience) {}

  const LayerPatience& patience() const { return patience_; }

  /// Takes a mask, room for its greys, and up to two pages from the top of the arena that the child shares.
  Status prepare(const PrintGrid& grid, bool shows_grey, Arena& arena) override;
  /// @retval ErrorCode::kMalformed      also if the child crashed or hung
  /// @retval ErrorCode::kDeviceTimeout  no child can be started any more
  Status decode(int file, std::string_view name, const ArchiveLayer& layer, const MaskTurn& turn, BitImage out,
                GreyRuns& greys) override;

  // The same in steps, for those who can't wait: begin(), then finish() until it is true or fails.

  /// @pre no child runs
  /// @retval ErrorCode::kDeviceTimeout  no child can be started any more
  [[nodiscard]] Status begin(int file, std::string_view name, const ArchiveLayer& layer, const MaskTurn& turn);
  /// @param patience    how long to wait for the child
  /// @param out, greys  overwritten once the layer is decoded
  /// @returns whether it is; false: the child still works
  /// @retval as decode(); the child has ended then, unless no child can be started any more
  [[nodiscard]] Expected<bool> finish(std::chrono::milliseconds patience, BitImage out, GreyRuns& greys);
  /// Kills the child and waits for its end, or for the template's if that does not report it.
  /// @returns the error of a layer that took too long
  /// @retval ErrorCode::kDeviceTimeout  no child can be started any more
  Error give_up();

 private:
  Error broke(const char* how) const;

  SlicingChild& child_;
  PrinterVolume printer_;
  LayerPatience patience_;
  std::span<std::byte> mask_;      ///< on a page
  std::span<const GreyRun> runs_;  ///< behind it
  FixedText<256> name_;            ///< of the archive whose layer is decoded
  std::uint64_t number_ = 0;       ///< of that layer
};

}  // namespace plumbline::firmware
