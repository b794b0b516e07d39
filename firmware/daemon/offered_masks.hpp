#pragma once

#include <cstdint>
#include <memory>
#include <optional>

#include "firmware/pictures/mask_window.hpp"
#include "firmware/print/job/mask_source.hpp"
#include "firmware/print/job/sliced_scan.hpp"
#include "firmware/settings/board_file.hpp"
#include "firmware/settings/print_profile.hpp"
#include "slicer/core/arena.hpp"
#include "slicer/core/error.hpp"

namespace plumbline::firmware {

/// The masks that would be printed, to look at while the printer asks whether to print them.
class OfferedMasks {
 public:
  virtual ~OfferedMasks() = default;
  /// Draws part of the mask of a layer.
  /// @returns false: it is being made. Ask again
  /// @retval ErrorCode::kBadSetting  there is no such layer
  /// @retval any error of its source
  [[nodiscard]] virtual Expected<bool> draw(std::uint32_t layer, const MaskWindow& window, MaskPicture& picture) = 0;
};

/// Those of a scan. Its destructor releases the arena.
class OfferedScanMasks final : public OfferedMasks {
 public:
  /// Takes a mask stream from the bottom of the arena.
  /// @param sliced  must outlive it, as must the arena
  /// @param grey    as StreamMasks::create() has it
  /// @retval ErrorCode::kOutOfMemory
  [[nodiscard]] static Expected<std::unique_ptr<OfferedScanMasks>> create(const SlicedScan& sliced,
                                                                          const CureModel& grey, Arena& arena);
  ~OfferedScanMasks() override { arena_.release_bottom(mark_); }
  OfferedScanMasks(const OfferedScanMasks&) = delete;
  OfferedScanMasks& operator=(const OfferedScanMasks&) = delete;

  /// At once. A layer above the one before costs the crossings between them, one below it all crossings from layer 0.
  Expected<bool> draw(std::uint32_t layer, const MaskWindow& window, MaskPicture& picture) override;

 private:
  explicit OfferedScanMasks(Arena& arena) : arena_(arena), mark_(arena.bottom_mark()) {}

  Arena& arena_;
  std::size_t mark_;
  std::optional<StreamMasks> stream_;
};

/// The error of a layer that a stack of `layers` does not have.
[[nodiscard]] tl::unexpected<Error> no_such_layer(std::uint32_t layer, std::uint32_t layers);

}  // namespace plumbline::firmware
