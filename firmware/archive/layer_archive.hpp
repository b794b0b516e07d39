#pragma once
/// The layers in an archive of a sliced print: .sl1, .sl1s, .cws, .uvj, .nanodlp, or a zip of numbered PNG files.

#include <array>
#include <cstdint>
#include <span>
#include <string>
#include <string_view>

#include "firmware/archive/archive_settings.hpp"
#include "firmware/archive/zip_reader.hpp"
#include "firmware/pictures/mask_decoder.hpp"
#include "firmware/pictures/png.hpp"
#include "slicer/core/bit_image.hpp"
#include "slicer/core/error.hpp"

namespace plumbline::firmware::inline archive {

/// Whether a name ends as that of an archive of a sliced print does (kArchiveEndings), in any case.
bool is_archive_name(std::string_view name);

/// A layer of an archive. Stored byte for byte.
struct ArchiveLayer {
  ZipPlace place;
  std::uint64_t number = 0;  ///< in its name
  std::uint64_t hash = 0;    ///< mask_hash(), once it was read
};

class LayerArchive {
 public:
  /// Reads the directory and the settings, and the size of the first layer. A layer is a PNG file with a number in its name,
  /// unless it is a thumbnail or a preview. The last number of each name gives the order.
  /// @param file  see ZipReader::open()
  /// @retval any error of ZipReader
  /// @retval ErrorCode::kNoPoints    no layer, or more than PrintGrid::kMaxLayers
  /// @retval ErrorCode::kTruncated    another number of layers than its settings declare
  /// @retval ErrorCode::kMalformed    settings that SettingsReader refuses, or a first layer that is no PNG
  /// @retval ErrorCode::kUnsupported  a print that ArchiveSettings::complete() refuses
  [[nodiscard]] static Expected<LayerArchive> open(int file, std::string_view name);
  /// The same for a file in memory, which must outlive the archive.
  [[nodiscard]] static Expected<LayerArchive> open(std::span<const std::byte> file, std::string_view name);

  std::uint32_t layers() const { return layers_; }
  std::uint32_t columns() const { return columns_; }  ///< pixels along x of the plate
  std::uint32_t rows() const { return rows_; }        ///< along y
  const ArchiveSettings& settings() const { return settings_; }
  const MaskTurn& turn() const { return turn_; }
  /// Turns the masks by 90 degrees if that makes them fit the panel: if they have its columns as rows and its rows as columns.
  void turn_for(std::uint32_t columns, std::uint32_t rows);
  bool is_turned() const { return turned_; }  ///< by turn_for()

  /// @param out  layers() of them, lowest first
  /// @retval ErrorCode::kMalformed  two layers have one number, or a number is missing
  [[nodiscard]] Status list(std::span<ArchiveLayer> out);

  /// @param out   columns() x rows(), row 0 with the smallest y
  /// @param grey, greys  may be null; see decode_turned_mask()
  /// @retval any error of decode_turned_mask(), with the names of the archive and the layer
  [[nodiscard]] Status read(const ArchiveLayer& layer, BitImage out, GreyShare* grey = nullptr,
                            GreyRuns* greys = nullptr);

  /// Draws the thumbnail or preview that the archive's slicer has put in: of those that are as large as `wanted`, the smallest, else the
  /// largest. Looks at the first kMostThumbnails.
  /// @param rgb  as that of decode_reduced()
  /// @returns false: there is none
  /// @retval any error of ZipReader and decode_reduced()
  [[nodiscard]] Expected<bool> draw_thumbnail(std::span<std::uint8_t> rgb, const PngSize& wanted);
  static constexpr std::size_t kMostThumbnails = 8;

 private:
  explicit LayerArchive(ZipReader zip) : zip_(std::move(zip)) {}
  [[nodiscard]] static Expected<LayerArchive> open(Expected<ZipReader> zip);
  [[nodiscard]] Status read_settings(const ZipPlace& place, std::size_t file);
  [[nodiscard]] Expected<PngSize> read_size(const ZipPlace& place, const char* what);

  ZipReader zip_;
  ArchiveSettings settings_;
  MaskTurn turn_;
  bool turned_ = false;
  std::uint32_t layers_ = 0, columns_ = 0, rows_ = 0;
  std::array<ZipPlace, kMostThumbnails> thumbnails_{};
  std::size_t thumbnail_count_ = 0;
};

/// Reads one layer of an archive that LayerArchive has opened before.
/// @param turn  LayerArchive::turn()
/// @retval any error of ZipReader and decode_turned_mask()
[[nodiscard]] Status read_archive_layer(int file, std::string_view name, const ArchiveLayer& layer,
                                        const MaskTurn& turn, BitImage out, GreyRuns* greys = nullptr);

}  // namespace plumbline::firmware::inline archive
