#pragma once
/// Masks as PNG files in a folder or an archive, of plumbline or another slicer.

#include <cstddef>
#include <cstdint>
#include <optional>
#include <string>
#include <string_view>
#include <vector>

#include "firmware/archive/layer_archive.hpp"
#include "firmware/io/descriptor.hpp"
#include "slicer/core/bit_image.hpp"
#include "slicer/core/error.hpp"

namespace plumbline::firmware {

/// Figures of a stack that masks don't have.
struct StackScale {
  double pitch_x_mm = 0, pitch_y_mm = 0, layer_height_mm = 0;
  bool has_panel = true;  ///< the masks are as large as a panel
};

class MaskStack {
 public:
  static constexpr std::uint32_t kMostLayers = 65535;

  /// Lists the PNG files of a folder, or of its folder `layers`. They are layers in the order of the last number in their names;
  /// those without a number, thumbnails and previews are left out.
  /// An archive's are LayerArchive's.
  /// @retval ErrorCode::kCannotOpen  the folder can't be listed
  /// @retval any error of LayerArchive
  /// @retval ErrorCode::kNoPoints    it has no such file
  /// @retval ErrorCode::kMalformed   two files have one number, a number is missing, or the first one is no PNG
  [[nodiscard]] static Expected<MaskStack> open(const std::string& path);

  std::uint32_t layers() const { return static_cast<std::uint32_t>(archive_ ? archive_layers_.size() : files_.size()); }
  std::uint32_t columns() const { return columns_; }
  std::uint32_t rows() const { return rows_; }
  /// From a manifest.json beside the layers, or an archive's settings; none: they don't have it.
  const std::optional<StackScale>& scale() const { return scale_; }

  /// An archive's: LayerArchive::turn_for(). A folder's lie as they are.
  void turn_for(std::uint32_t columns, std::uint32_t rows);

  /// Reads a layer. Grey levels above 127 are white, as in UVtools.
  /// @param out  columns() x rows()
  /// @retval ErrorCode::kCannotOpen, kCannotRead
  /// @retval ErrorCode::kMalformed  no PNG, damaged, or of another size than the first layer
  [[nodiscard]] Status read(std::uint32_t layer, BitImage out);
  /// Of the layers of an archive that were read so far.
  const GreyShare& grey() const { return grey_; }

 private:
  [[nodiscard]] Status load(std::uint32_t layer);

  [[nodiscard]] static Expected<MaskStack> open_archive(const std::string& path);

  std::vector<std::string> files_;
  Descriptor file_;  ///< of the archive
  std::optional<LayerArchive> archive_;
  std::vector<ArchiveLayer> archive_layers_;
  GreyShare grey_;
  std::vector<std::byte> bytes_;  ///< of the file that was loaded last
  std::uint32_t columns_ = 0, rows_ = 0;
  std::optional<StackScale> scale_;
};

/// Finds "pixel_pitch_mm", "layer_height_mm" and whether "printer" is null in the text of a manifest.
/// @returns none if a length is missing or not between 0.001 and 10 mm
std::optional<StackScale> scale_in_manifest(std::string_view json);

}  // namespace plumbline::firmware
