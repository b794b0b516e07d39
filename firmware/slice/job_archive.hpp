#pragma once
/// The .sl1 archive that a job's masks go to, for PrusaSlicer, UVtools and other printers:
///
///   layer00000.png ...          the masks, as in a folder of layers
///   thumbnail/thumbnail*.png    the print in the two sizes that printers show
///   config.ini, prusaslicer.ini sl1_config.hpp

#include <cstdint>
#include <span>
#include <string>
#include <string_view>

#include "firmware/archive/sl1_config.hpp"
#include "firmware/archive/zip_writer.hpp"
#include "slicer/core/error.hpp"

namespace plumbline::firmware {

/// Whether an output's name ends in .sl1 or .sl1s, in any case.
bool is_sl1_name(std::string_view path);

/// Pixels of a thumbnail.
struct ThumbnailSize {
  std::uint32_t columns = 0, rows = 0;
};
inline constexpr ThumbnailSize kThumbnailSizes[] = {{400, 400}, {800, 480}};  ///< as PrusaSlicer makes them

class JobArchive {
 public:
  /// @retval the errors of ZipWriter::create()
  [[nodiscard]] static Expected<JobArchive> open(const std::string& path);

  /// @param layer  0 to 65535
  /// @retval ErrorCode::kCannotWrite, as of the others
  [[nodiscard]] Status write_layer(std::uint32_t layer, std::span<const std::byte> png);
  [[nodiscard]] Status write_thumbnail(ThumbnailSize size, std::span<const std::byte> png);
  /// Writes the settings, and gives the archive its name. Without this call nothing is left of it.
  [[nodiscard]] Status finish(const Sl1Job& job);

 private:
  explicit JobArchive(ZipWriter zip) : zip_(std::move(zip)) {}
  ZipWriter zip_;
};

}  // namespace plumbline::firmware
