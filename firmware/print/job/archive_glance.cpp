#include "firmware/print/job/archive_glance.hpp"

#include <algorithm>
#include <cstdint>
#include <utility>

#include "firmware/pictures/preview/preview_page.hpp"
#include "firmware/print/job/sliced_archive.hpp"

namespace plumbline::firmware {
namespace {

constexpr const char* kStage = "archive picture";
constexpr std::uint64_t kMostPixels = 512'000'000;  // of all layers that are decoded: 10 s to 20 s of a Cortex-A53
constexpr std::uint32_t kMostLayers = 128;          // two for each row of the picture
constexpr std::uint32_t kMostColumns = 1024;        // of the coarse print: a part may be small on its panel
constexpr float kLayerHeightMm = 0.05F;             // if the archive does not say

/// Takes the middle pixel of each square.
void reduce(ConstBitImage mask, std::uint32_t side, BitImage out) {
  out.clear();
  for (std::uint32_t row = 0; row < out.rows(); ++row) {
    for (std::uint32_t column = 0; column < out.columns(); ++column) {
      if (mask.at(column * side + side / 2, row * side + side / 2)) out.set(column, row);
    }
  }
}

/// A coarse print of some of the layers.
/// @returns an R-Rep without crossings if the arena has no room for it
Expected<RRep> sample_layers(LayerArchive& archive, const PrinterVolume& printer, Arena& arena) {
  const std::uint32_t columns = archive.columns(), rows = archive.rows(), layers = archive.layers();
  const auto listed = arena.take_bottom<ArchiveLayer>(layers, kStage);
  PLUMBLINE_TRY(listed);
  PLUMBLINE_TRY(archive.list(*listed));
  const std::uint64_t affordable = kMostPixels / (std::uint64_t{columns} * rows);
  const auto kept = static_cast<std::uint32_t>(std::clamp<std::uint64_t>(affordable, 1, kMostLayers));
  const std::uint32_t step = (layers + kept - 1) / kept;
  const std::uint32_t side = (std::max(columns, rows) + kMostColumns - 1) / kMostColumns;
  const ArchiveSettings& settings = archive.settings();
  PrintGrid grid;
  grid.columns = std::max(columns / side, 1U);
  grid.rows = std::max(rows / side, 1U);
  grid.layers = (layers + step - 1) / step;
  const auto pitch = [side](std::optional<double> panel, std::uint32_t pixels, float printers) {
    return static_cast<float>(side) * (panel ? static_cast<float>(*panel / pixels) : printers);
  };
  grid.pitch_x_mm = pitch(settings.width_mm(), columns, printer.pitch_x_mm);
  grid.pitch_y_mm = pitch(settings.depth_mm(), rows, printer.pitch_y_mm);
  const auto height = static_cast<float>(settings.value(PrintKey::kLayerHeight).value_or(kLayerHeightMm));
  grid.layer_height_mm = static_cast<float>(step) * height;
  const std::size_t all = BitImage::words_needed(columns, rows), few = BitImage::words_needed(grid.columns, grid.rows);
  const auto words = arena.take_top<std::uint64_t>(all + 2 * few, kStage);
  PLUMBLINE_TRY(words);
  const BitImage whole(words->first(all), columns, rows);
  BitImage mask(words->subspan(all, few), grid.columns, grid.rows), below(words->last(few), grid.columns, grid.rows);
  below.clear();
  LayerCrossings crossings = LayerCrossings::make(grid, arena);
  for (std::uint32_t k = 0; k < grid.layers; ++k) {
    PLUMBLINE_TRY(archive.read((*listed)[std::min(k * step + step / 2, layers - 1)], whole));
    reduce(whole, side, mask);
    crossings.next(k, mask, below);
    std::swap(mask, below);
  }
  return crossings.rrep(grid);
}

}  // namespace

Status draw_archive_picture(LayerArchive& archive, const PrinterVolume& printer, Arena& arena, ScanPicture& picture) {
  picture.columns = ScanPicture::kMostColumns;
  picture.rows = ScanPicture::kMostRows;
  preview::draw_background({picture.bytes(), picture.columns, picture.rows});
  const auto drawn = archive.draw_thumbnail(picture.bytes(), {picture.columns, picture.rows});
  PLUMBLINE_TRY(drawn);
  if (!*drawn) {
    const auto rrep = sample_layers(archive, printer, arena);
    PLUMBLINE_TRY(rrep);
    if (rrep->packed.empty()) return fail(ErrorCode::kNoPoints, "there is nothing to draw, or no room for it");
    const auto rgb = draw_thumbnail(*rrep, Supports{}, picture.columns, picture.rows, arena);
    PLUMBLINE_TRY(rgb);
    std::copy(rgb->begin(), rgb->end(), picture.bytes().begin());
  }
  keep_five_bits(picture.bytes());
  return {};
}

}  // namespace plumbline::firmware
