#pragma once
/// What the firmware asks the slicing child for.

#include <cstdint>
#include <optional>

#include "firmware/archive/layer_archive.hpp"
#include "firmware/io/fixed_text.hpp"
#include "slicer/slice_settings.hpp"
#include "slicer/supports/support_settings.hpp"

namespace plumbline {

/// What is asked of an archive that somebody else has sliced.
struct ArchiveRequest {
  enum class Ask : std::uint8_t {
    kNothing,  ///< it is no archive
    kCheck,    ///< look through all of it
    kLayer,    ///< decode one layer
  };
  Ask ask = Ask::kNothing;
  ArchiveLayer layer;  ///< kLayer
  MaskTurn turn;       ///< kLayer
  std::uint64_t mask_at =
      0;  ///< kLayer: byte of the arena where the mask goes, on a page. The child can't write to the arena before it
};

/// One scan, a stick's job file, or an archive. Its bytes come through the child's descriptor.
struct ScanRequest {
  bool is_job_file = false;  ///< only its name and size count
  FixedText<256> name;
  std::optional<std::uint64_t> size;  ///< bytes, if known
  SliceSettings settings;             ///< with a printer
  std::optional<SupportSettings> supports;
  ArchiveRequest archive;
};

}  // namespace plumbline
