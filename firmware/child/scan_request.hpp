#pragma once
/// What the firmware asks the slicing child for.

#include <array>
#include <cstdint>
#include <optional>
#include <span>
#include <string_view>

#include "firmware/archive/layer_archive.hpp"
#include "firmware/io/text/fixed_text.hpp"
#include "slicer/reader/scan_sources.hpp"
#include "slicer/slice_settings.hpp"
#include "slicer/supports/support_settings.hpp"

namespace plumbline::firmware {

/// What is asked of an archive that somebody else has sliced.
struct ArchiveRequest {
  enum class Ask : std::uint8_t {
    kNothing,  ///< it is no archive
    kCheck,    ///< look through all of it
    kLayer,    ///< decode one layer
    kGlance,   ///< draw a small picture
  };
  Ask ask = Ask::kNothing;
  ArchiveLayer layer;  ///< kLayer
  MaskTurn turn;       ///< kLayer
  /// kLayer: byte of the arena where the mask goes, on a page, and behind it its grey pixels. The child can't write to the arena before it.
  std::uint64_t mask_at = 0;
  bool shows_grey = false;  ///< kCheck, kLayer: the panel does
};

/// One of the files of a request.
struct RequestedFile {
  FixedText<256> name;
  std::optional<std::uint64_t> size;  ///< bytes, if known
};

/// One scan of one or several files, a stick's job file, or an archive. The bytes of file i come through the child's descriptor i.
struct ScanRequest {
  bool is_job_file = false;  ///< only the file counts
  bool proposes = false;     ///< only the best ways up are wanted. The rotation about x and about y is not used
  bool is_glance = false;    ///< only a small picture of the scan is wanted; of an archive, ArchiveRequest says so
  FixedText<256> name;       ///< for messages
  std::array<RequestedFile, kMostScans> file;
  std::uint32_t file_count = 0;
  SliceSettings settings;  ///< with a printer
  ArchiveRequest archive;

  /// @pre file_count < kMostScans
  void add_file(std::string_view file_name, std::optional<std::uint64_t> bytes) {
    RequestedFile& added = file[file_count++];
    added.name.add("%.*s", static_cast<int>(file_name.size()), file_name.data());
    added.size = bytes;
  }
  std::span<const RequestedFile> files() const { return std::span(file).first(file_count); }
};

}  // namespace plumbline::firmware
