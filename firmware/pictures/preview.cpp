#include "firmware/pictures/preview.hpp"

#include <algorithm>
#include <bit>
#include <cassert>
#include <cmath>
#include <cstdio>

#include "firmware/pictures/preview_font.hpp"
#include "firmware/pictures/preview_page.hpp"
#include "firmware/pictures/preview_shading.hpp"
#include "firmware/pictures/preview_survey.hpp"
#include "slicer/core/bit_image.hpp"

namespace plumbline {

using namespace preview;

namespace {

constexpr Colour kLine{112, 123, 136};

void draw_centred(const Picture& picture, std::int64_t centre, std::int64_t top, std::string_view text,
                  const TextStyle& style) {
  draw_text(picture, centre - text_width(text, style) / 2, top, text, style);
}

/// Draws a scale bar: the longest of 1, 2 or 5 times a power of ten mm that takes at most 200 pixels.
void draw_scale_bar(const Picture& picture, double pixels_per_mm, std::int64_t left, std::int64_t top) {
  double length = 0.01;
  for (const double factor : {1.0, 10.0, 100.0, 1000.0, 10000.0}) {
    for (const double digit : {0.01, 0.02, 0.05}) {
      if (digit * factor * pixels_per_mm <= 200.0) length = digit * factor;
    }
  }
  const auto pixels = static_cast<std::int64_t>(std::floor(length * pixels_per_mm + 0.5));
  picture.fill(left, top + 5, pixels, 3, kInk);
  picture.fill(left, top, 2, 13, kInk);
  picture.fill(left + pixels - 2, top, 2, 13, kInk);
  char label[32];
  std::snprintf(label, sizeof label, "%g mm", length);
  draw_text(picture, left + pixels + 14, top, label, {.scale = 2, .colour = kInk});
}

/// Draws the line that the object stands on, fading out at both ends.
void draw_floor(const Picture& picture, std::int64_t left, std::int64_t width, std::int64_t row) {
  constexpr std::int64_t kFade = 40;
  for (std::int64_t x = -kFade; x < width + kFade; ++x) {
    const std::int64_t inside = std::min(x + kFade, width + kFade - x);
    const float cover = std::min(static_cast<float>(inside) / kFade, 1.0F);
    picture.blend(left + x, row, kLine, cover);
    picture.blend(left + x, row + 1, kLine, 0.4F * cover);
  }
}

std::size_t material_bytes(const PrintGrid& grid) {
  return std::max<std::size_t>(height_cells(grid), std::max(grid.columns, grid.rows));
}

}  // namespace

std::size_t preview_bytes(const PrintGrid& grid) {
  return Arena::rounded(BitImage::words_needed(grid.columns, grid.rows) * sizeof(std::uint64_t)) +
         Arena::rounded(std::size_t{std::max(grid.columns, grid.rows)} * sizeof(std::uint32_t)) +
         Arena::rounded(std::size_t{(grid.columns + 63) / 64} * sizeof(std::uint64_t)) +
         Arena::rounded(height_cells(grid) * sizeof(std::uint16_t)) + Arena::rounded(material_bytes(grid)) +
         2 * Arena::rounded(kSamples * sizeof(float)) + Arena::rounded(kSamples);
}

Status draw_preview(const RRep& rrep, const Supports& supports, const PreviewText& text, Arena& arena,
                    std::span<std::uint8_t> rgb) {
  constexpr const char* kStage = "preview";
  assert(rgb.size() == std::size_t{3} * kPreviewColumns * kPreviewRows);
  const PrintGrid& grid = rrep.grid;
  const ArenaScope scope(arena);
  const auto words = arena.take_top<std::uint64_t>(BitImage::words_needed(grid.columns, grid.rows), kStage);
  PLUMBLINE_TRY(words);
  const auto nearest = arena.take_top<std::uint32_t>(std::max(grid.columns, grid.rows), kStage);
  PLUMBLINE_TRY(nearest);
  const auto found = arena.take_top<std::uint64_t>((grid.columns + 63) / 64, kStage);
  PLUMBLINE_TRY(found);
  const auto heights = arena.take_top<std::uint16_t>(height_cells(grid), kStage);
  PLUMBLINE_TRY(heights);
  const auto materials = arena.take_top<std::uint8_t>(material_bytes(grid), kStage);
  PLUMBLINE_TRY(materials);
  const auto samples = arena.take_top<std::uint8_t>(kSamples, kStage);
  PLUMBLINE_TRY(samples);
  const auto depths = arena.take_top<float>(kSamples, kStage);
  PLUMBLINE_TRY(depths);
  const auto scratch = arena.take_top<float>(kSamples, kStage);
  PLUMBLINE_TRY(scratch);

  const Picture picture{rgb, kPreviewColumns, kPreviewRows};
  draw_background(picture);
  const TextStyle title{.scale = 4, .colour = kInk}, plain{.scale = 2, .colour = kInk},
      pale{.scale = 2, .colour = kPaleInk};
  const Extent object = find_extent(rrep, *words);
  if (!object.empty()) {
    const Extent extent = with_supports(object, supports, grid);
    const Layout layout = lay_out(extent, grid);
    std::span<float> rest = *depths;
    std::span<std::uint8_t> shown = *samples;
    const auto take_map = [&](std::uint32_t width, std::uint32_t height) {
      const std::uint32_t columns = width * kSamplesPerPixel, rows = height * kSamplesPerPixel;
      const std::size_t count = std::size_t{columns} * rows;
      const DepthMap map{rest.first(count), shown.first(count), columns, rows};
      rest = rest.subspan(count);
      shown = shown.subspan(count);
      std::fill(map.depth.begin(), map.depth.end(), DepthMap::kEmpty);
      return map;
    };
    const DepthMap front = take_map(layout.width, layout.height), side = take_map(layout.depth, layout.height),
                   top = take_map(layout.width, layout.depth);
    survey(rrep, supports, extent, layout, {*words, *nearest, *found, *heights, *materials}, front, side, top);

    const auto smooth = [&](const DepthMap& map, float across_mm, float up_mm, float deep_mm) {
      const auto in_samples = [&](float mm) {
        return std::max(1.0F, mm * static_cast<float>(layout.samples_per_mm()));
      };
      smooth_depth(map, *scratch, {.across = in_samples(std::max(across_mm, up_mm)), .deep = in_samples(deep_mm)});
    };
    smooth(front, grid.pitch_x_mm, grid.layer_height_mm, grid.pitch_y_mm);
    smooth(side, grid.pitch_y_mm, grid.layer_height_mm, grid.pitch_x_mm);
    smooth(top, grid.pitch_x_mm, grid.pitch_y_mm, grid.layer_height_mm);

    const std::int64_t upper = layout.floor - layout.height;
    const std::int64_t top_upper = layout.floor - (std::int64_t{layout.tall} + layout.depth) / 2;
    draw_floor(picture, layout.front_left, layout.width, layout.floor);
    draw_floor(picture, layout.side_left, layout.depth, layout.floor);
    shade_depth(front, picture, layout.front_left, upper, kMaterials);
    shade_depth(side, picture, layout.side_left, upper, kMaterials);
    shade_depth(top, picture, layout.top_left, top_upper, kMaterials);

    const std::int64_t label = layout.floor + 18;
    draw_centred(picture, layout.front_left + layout.width / 2, label, "front", pale);
    draw_centred(picture, layout.side_left + layout.depth / 2, label, "side", pale);
    draw_centred(picture, layout.top_left + layout.width / 2, label, "top", pale);
    draw_scale_bar(picture, layout.pixels_per_mm, kMargin, 106);
  }

  const std::string_view size = object.empty() ? "empty" : text.size;
  const std::uint32_t size_width = text_width(size, plain);
  draw_text(picture, std::int64_t{kPreviewColumns} - kMargin - size_width, 52, size, plain);
  draw_text(picture, kMargin, 38, cut(text.name, kPreviewColumns - 3 * kMargin - size_width, title), title);
  std::int64_t line = 806;
  for (const auto caption : text.captions.first(std::min(text.captions.size(), kMaxPreviewCaptions))) {
    draw_text(picture, kMargin, line, cut(caption, kPreviewColumns - 2 * kMargin, pale), pale);
    line += 28;
  }
  return {};
}

Expected<std::span<const std::byte>> encode_preview(const RRep& rrep, const Supports& supports, const PreviewText& text,
                                                    Arena& arena, PngEncoder& encoder) {
  const ArenaScope scope(arena);
  const auto rgb = arena.take_top<std::uint8_t>(std::size_t{3} * kPreviewColumns * kPreviewRows, "preview");
  PLUMBLINE_TRY(rgb);
  PLUMBLINE_TRY(draw_preview(rrep, supports, text, arena, *rgb));
  return encoder.encode(*rgb, kPreviewColumns, kPreviewRows);
}

}  // namespace plumbline
