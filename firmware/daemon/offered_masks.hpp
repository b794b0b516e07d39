#pragma once

#include <cstdint>
#include <memory>
#include <optional>

#include "firmware/pictures/job_pictures.hpp"
#include "firmware/print/mask_renderer.hpp"
#include "firmware/print/mask_source.hpp"
#include "firmware/print/sliced_scan.hpp"
#include "firmware/settings/board_file.hpp"
#include "firmware/settings/print_profile.hpp"
#include "slicer/core/arena.hpp"
#include "slicer/core/error.hpp"

namespace plumbline {

/// The masks that would be printed, to look at while the printer asks whether to print them. Its destructor releases the arena.
class OfferedMasks {
 public:
  /// Takes a mask stream and a mask from the bottom of the arena.
  /// @param sliced  must outlive it, as must the arena
  /// @retval ErrorCode::kOutOfMemory
  /// @retval the errors of plan_print()
  [[nodiscard]] static Expected<std::unique_ptr<OfferedMasks>> create(const SlicedScan& sliced,
                                                                      const PrintProfile& profile,
                                                                      const MachineFile& machine, Arena& arena);
  ~OfferedMasks() { arena_.release_bottom(mark_); }
  OfferedMasks(const OfferedMasks&) = delete;
  OfferedMasks& operator=(const OfferedMasks&) = delete;

  /// A layer above the one before costs the crossings between them, one below it all crossings from layer 0.
  /// @retval ErrorCode::kBadSetting  there is no such layer
  [[nodiscard]] Status draw(std::uint32_t layer, LayerPicture& picture);

 private:
  explicit OfferedMasks(Arena& arena) : arena_(arena), mark_(arena.bottom_mark()) {}

  Arena& arena_;
  std::size_t mark_;
  std::optional<StreamMasks> stream_;
  std::optional<MaskRenderer> masks_;
  BitImage mask_;
};

}  // namespace plumbline
