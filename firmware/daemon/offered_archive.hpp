#pragma once
/// The masks of an archive that somebody else has sliced, to look at before it is printed.

#include <chrono>
#include <cstdint>
#include <memory>
#include <optional>
#include <string_view>

#include "firmware/child/child_layer_decoder.hpp"
#include "firmware/daemon/offered_masks.hpp"
#include "firmware/io/text/fixed_text.hpp"
#include "firmware/print/job/sliced_archive.hpp"

namespace plumbline::firmware {

/// Decodes one layer at a time, each in a child of its own without rights, and never waits for it. Its destructor ends the child and
/// releases the arena.
class OfferedArchiveMasks final : public OfferedMasks {
 public:
  /// Takes a mask from the bottom of the arena, and what the decoder needs from its top.
  /// @param file        the archive's descriptor; must stay open
  /// @param sliced      must outlive it, as must the decoder and the arena
  /// @param shows_grey  the panel does, as when the archive was checked
  /// @retval ErrorCode::kOutOfMemory
  [[nodiscard]] static Expected<std::unique_ptr<OfferedArchiveMasks>> create(int file, std::string_view name,
                                                                             const SlicedArchive& sliced,
                                                                             ChildLayerDecoder& decoder,
                                                                             bool shows_grey, Arena& arena);
  ~OfferedArchiveMasks() override;
  OfferedArchiveMasks(const OfferedArchiveMasks&) = delete;
  OfferedArchiveMasks& operator=(const OfferedArchiveMasks&) = delete;

  /// A layer is kept until another one is asked for, so that everybody who waits for it gets it.
  /// @retval ErrorCode::kMalformed  it can't be decoded, or is not the one that was checked
  Expected<bool> draw(std::uint32_t layer, const MaskWindow& window, MaskPicture& picture) override;

 private:
  using HostClock = std::chrono::steady_clock;

  OfferedArchiveMasks(int file, std::string_view name, const SlicedArchive& sliced, ChildLayerDecoder& decoder,
                      Arena& arena);
  void look();

  int file_;
  FixedText<256> name_;
  const SlicedArchive& sliced_;
  ChildLayerDecoder& decoder_;
  Arena& arena_;
  std::size_t bottom_;
  ArenaScope top_;
  BitImage mask_;                       ///< the layer that was decoded last
  GreyRuns greys_;                      ///< of it
  std::optional<std::uint32_t> asked_;  ///< the layer that the child decodes
  HostClock::time_point asked_at_;
  std::optional<std::uint32_t> done_;  ///< the layer that it decoded last,
  std::optional<Error> problem_;       ///< and what was wrong with it
};

}  // namespace plumbline::firmware
