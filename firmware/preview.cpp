#include "firmware/preview.hpp"

#include <algorithm>
#include <bit>
#include <cassert>
#include <cmath>
#include <cstdio>

#include "firmware/preview_font.hpp"
#include "firmware/preview_shading.hpp"
#include "slicer/core/bit_image.hpp"

namespace plumbline {
namespace {

// The page, in pixels.
constexpr std::uint32_t kMargin = 60;
constexpr std::uint32_t kTop = 120, kBottom = 740;  // of the area for the views
constexpr std::uint32_t kGap = 90;                  // between two views
constexpr std::uint32_t kAreaColumns = kPreviewColumns - 2 * kMargin - 2 * kGap, kAreaRows = kBottom - kTop;
constexpr double kMostPixelsPerMm = 120.0;
constexpr std::size_t kSamples =
    std::size_t{kAreaColumns} * kSamplesPerPixel * kAreaRows * kSamplesPerPixel;  // of all three maps together

constexpr Colour kSkyColour{46, 53, 63}, kFloorColour{70, 79, 91};
constexpr Colour kMaterial{255, 243, 222}, kInk{236, 232, 224}, kPaleInk{158, 168, 180}, kLine{112, 123, 136};

constexpr std::uint32_t kMostHeights = 2048;  // cells a side of the map of highest surfaces

/// Every so many pixels the highest surface is kept, a power of two.
std::uint32_t height_step(const PrintGrid& grid) {
  std::uint32_t step = 1;
  while (std::max(grid.columns, grid.rows) / step > kMostHeights) step *= 2;
  return step;
}
std::size_t height_cells(const PrintGrid& grid) {
  const std::uint32_t step = height_step(grid);
  return std::size_t{(grid.columns + step - 1) / step} * ((grid.rows + step - 1) / step);
}

/// Half-open ranges of pixels and layers that hold the object.
struct Extent {
  std::uint32_t column = 0, column_end = 0, row = 0, row_end = 0, layer = 0, layer_end = 0;

  bool empty() const { return column >= column_end; }
};

/// The section as the crossings have it, layer after layer.
class Section {
 public:
  Section(const RRep& rrep, std::span<std::uint64_t> words)
      : rrep_(rrep), image_(words, rrep.grid.columns, rrep.grid.rows) {
    image_.clear();
  }

  /// Toggles the crossings of `layer`, which is the one after the last.
  /// @param heard  called with column, row and whether the pixel is inside now
  template <class Heard>
  void advance(std::uint32_t layer, Heard heard) {
    for (std::uint32_t k = rrep_.first[layer]; k < rrep_.first[layer + 1]; ++k) {
      const std::uint32_t pixel = rrep_.pixel[k], row = pixel / rrep_.grid.columns;
      const std::uint32_t column = pixel - row * rrep_.grid.columns;
      std::uint64_t& word = image_.row(row)[column / 64];
      const std::uint64_t bit = std::uint64_t{1} << (column % 64);
      word ^= bit;
      heard(column, row, (word & bit) != 0);
    }
  }
  const BitImage& image() const { return image_; }

 private:
  const RRep& rrep_;
  BitImage image_;
};

Extent find_extent(const RRep& rrep, std::span<std::uint64_t> words) {
  Extent extent{rrep.grid.columns, 0, rrep.grid.rows, 0, rrep.grid.layers, 0};
  Section section(rrep, words);
  std::int64_t inside = 0;
  for (std::uint32_t layer = 0; layer < rrep.grid.layers; ++layer) {
    if (rrep.first[layer] == rrep.first[layer + 1]) continue;
    extent.layer = std::min(extent.layer, layer);
    extent.layer_end = layer;
    section.advance(layer, [&](std::uint32_t column, std::uint32_t row, bool is_inside) {
      extent.column = std::min(extent.column, column);
      extent.column_end = std::max(extent.column_end, column + 1);
      extent.row = std::min(extent.row, row);
      extent.row_end = std::max(extent.row_end, row + 1);
      inside += is_inside ? 1 : -1;
    });
  }
  if (inside > 0) extent.layer_end = rrep.grid.layers;  // the object goes on above the last layer
  return extent;
}

/// One scale for three views, and where they go.
struct Layout {
  double width_mm = 0, depth_mm = 0, height_mm = 0;  // x, y, z
  double pixels_per_mm = 0;
  std::uint32_t width = 0, depth = 0, height = 0;  // pixels
  std::uint32_t tall = 0;                          // pixels of the tallest view
  std::int64_t front_left = 0, side_left = 0, top_left = 0;
  std::int64_t floor = 0;  // row of the underside in the front and the side view

  Layout(const Extent& extent, const PrintGrid& grid) {
    width_mm = (extent.column_end - extent.column) * double{grid.pitch_x_mm};
    depth_mm = (extent.row_end - extent.row) * double{grid.pitch_y_mm};
    height_mm = (extent.layer_end - extent.layer) * double{grid.layer_height_mm};
    const double across = kAreaColumns / (2.0 * width_mm + depth_mm);
    const double up = kAreaRows / std::max(height_mm, depth_mm);
    pixels_per_mm = std::min({across, up, kMostPixelsPerMm});
    const auto pixels = [&](double mm, std::uint32_t most) {
      return std::clamp(static_cast<std::uint32_t>(mm * pixels_per_mm), 1U, most);
    };
    width = pixels(width_mm, kAreaColumns / 2);
    depth = pixels(depth_mm, std::min(kAreaColumns - 2 * width, kAreaRows));
    height = pixels(height_mm, kAreaRows);
    tall = std::max(height, depth);
    // What is left of the area's width goes between and beside the views.
    const std::int64_t spare = std::int64_t{kPreviewColumns} - 2 * kMargin - 2 * std::int64_t{width} - depth;
    const std::int64_t gap = std::clamp<std::int64_t>(spare / 4, kGap, 2 * kGap);
    front_left = (std::int64_t{kPreviewColumns} - 2 * std::int64_t{width} - depth - 2 * gap) / 2;
    side_left = front_left + width + gap;
    top_left = side_left + depth + gap;
    floor = (std::int64_t{kTop} + kBottom + tall) / 2;
  }
  double samples_per_mm() const { return pixels_per_mm * kSamplesPerPixel; }
};

/// Fills the three depth maps in one sweep over the layers.
class Surveyor {
 public:
  Surveyor(const RRep& rrep, const Extent& extent, const Layout& layout)
      : rrep_(rrep), extent_(extent), layout_(layout) {}

  void survey(Section& section, std::span<std::uint32_t> nearest, std::span<std::uint64_t> found,
              std::span<std::uint16_t> heights, const DepthMap& front, const DepthMap& side, const DepthMap& top) {
    const std::uint32_t step = height_step(rrep_.grid), shift = static_cast<std::uint32_t>(std::countr_zero(step));
    const std::uint32_t cells = (rrep_.grid.columns + step - 1) / step;
    std::fill(heights.begin(), heights.end(), std::uint16_t{0});
    // A surface that ends at layer k ends at its underside, k layer heights up. 0: nothing ended here.
    const auto heard = [&](std::uint32_t layer) {
      return [&, layer](std::uint32_t column, std::uint32_t row, bool inside) {
        if (inside || ((column | row) & (step - 1)) != 0) return;
        heights[std::size_t{row >> shift} * cells + (column >> shift)] = static_cast<std::uint16_t>(layer);
      };
    };
    std::int64_t line = std::int64_t{front.rows} - 1;  // of the front and the side view, from the underside up
    for (std::uint32_t layer = extent_.layer; layer < extent_.layer_end; ++layer) {
      section.advance(layer, heard(layer));
      if (line < 0 || layer_of(line, front.rows) > layer) continue;
      see_along_rows(section.image(), nearest, found);
      const std::int64_t first = line;
      for (; line >= 0 && layer_of(line, front.rows) <= layer; --line) {
        draw_front(front, static_cast<std::uint32_t>(line), nearest);
      }
      see_along_columns(section.image(), nearest);
      for (std::int64_t again = first; again > line; --again) {
        draw_side(side, static_cast<std::uint32_t>(again), nearest);
      }
    }
    if (extent_.layer_end < rrep_.grid.layers) section.advance(extent_.layer_end, heard(extent_.layer_end));
    draw_top(top, section.image(), heights, shift, cells);
  }

 private:
  static constexpr std::uint32_t kNone = 0xFFFFFFFFU;

  /// Index of the cell at `samples` samples from the low end of a range.
  std::uint32_t cell(double samples, double size_mm, std::uint32_t first, std::uint32_t end) const {
    const auto k = static_cast<std::uint32_t>(samples / (layout_.samples_per_mm() * size_mm));
    return std::min(first + k, end - 1);
  }
  std::uint32_t column_of(std::uint32_t sample) const {
    return cell(sample + 0.5, double{rrep_.grid.pitch_x_mm}, extent_.column, extent_.column_end);
  }
  /// Of sample `sample` counted from the back, where the side view has its left and the top view its upper end.
  std::uint32_t row_of(std::uint32_t sample, std::uint32_t samples) const {
    return cell(samples - sample - 0.5, double{rrep_.grid.pitch_y_mm}, extent_.row, extent_.row_end);
  }
  std::uint32_t layer_of(std::int64_t line, std::uint32_t lines) const {
    const double above = static_cast<double>(lines) - static_cast<double>(line) - 0.5;
    return cell(above, double{rrep_.grid.layer_height_mm}, extent_.layer, extent_.layer_end);
  }

  /// First row that holds each column, for the view along +y.
  void see_along_rows(const BitImage& image, std::span<std::uint32_t> nearest, std::span<std::uint64_t> found) const {
    const std::uint32_t first = extent_.column / 64, last = (extent_.column_end - 1) / 64;
    std::fill(nearest.begin() + extent_.column, nearest.begin() + extent_.column_end, kNone);
    std::fill(found.begin() + first, found.begin() + last + 1, std::uint64_t{0});
    for (std::uint32_t row = extent_.row; row < extent_.row_end; ++row) {
      const auto words = image.row(row);
      for (std::uint32_t w = first; w <= last; ++w) {
        std::uint64_t fresh = words[w] & ~found[w];
        found[w] |= fresh;
        for (; fresh != 0; fresh &= fresh - 1)
          nearest[w * 64 + static_cast<std::uint32_t>(std::countr_zero(fresh))] = row;
      }
    }
  }
  /// First column that holds each row, for the view along +x.
  void see_along_columns(const BitImage& image, std::span<std::uint32_t> nearest) const {
    const std::uint32_t first = extent_.column / 64, last = (extent_.column_end - 1) / 64;
    for (std::uint32_t row = extent_.row; row < extent_.row_end; ++row) {
      const auto words = image.row(row);
      nearest[row] = kNone;
      for (std::uint32_t w = first; w <= last && nearest[row] == kNone; ++w) {
        if (words[w] != 0) nearest[row] = w * 64 + static_cast<std::uint32_t>(std::countr_zero(words[w]));
      }
    }
  }

  float depth_of(std::uint32_t cells, double size_mm) const {
    return static_cast<float>(cells * size_mm * layout_.samples_per_mm());
  }
  void draw_front(const DepthMap& map, std::uint32_t line, std::span<const std::uint32_t> nearest) const {
    for (std::uint32_t u = 0; u < map.columns; ++u) {
      const std::uint32_t row = nearest[column_of(u)];
      if (row != kNone) map.at(u, line) = depth_of(row - extent_.row, double{rrep_.grid.pitch_y_mm});
    }
  }
  void draw_side(const DepthMap& map, std::uint32_t line, std::span<const std::uint32_t> nearest) const {
    for (std::uint32_t u = 0; u < map.columns; ++u) {
      const std::uint32_t column = nearest[row_of(u, map.columns)];
      if (column != kNone) map.at(u, line) = depth_of(column - extent_.column, double{rrep_.grid.pitch_x_mm});
    }
  }
  void draw_top(const DepthMap& map, const BitImage& last, std::span<const std::uint16_t> heights, std::uint32_t shift,
                std::uint32_t cells) const {
    for (std::uint32_t v = 0; v < map.rows; ++v) {
      const std::uint32_t row = row_of(v, map.rows) >> shift;
      for (std::uint32_t u = 0; u < map.columns; ++u) {
        const std::uint32_t column = column_of(u) >> shift;
        std::uint32_t height = heights[std::size_t{row} * cells + column];
        if (last.at(column << shift, row << shift)) height = extent_.layer_end;  // goes on above the last layer
        if (height > 0) map.at(u, v) = depth_of(extent_.layer_end - height, double{rrep_.grid.layer_height_mm});
      }
    }
  }

  const RRep& rrep_;
  const Extent& extent_;
  const Layout& layout_;
};

void draw_background(const Picture& picture) {
  for (std::uint32_t row = 0; row < picture.rows; ++row) {
    const float t = static_cast<float>(row) / static_cast<float>(picture.rows);
    Colour colour;
    for (std::size_t c = 0; c < 3; ++c) {
      colour[c] = static_cast<std::uint8_t>(static_cast<float>(kSkyColour[c]) * (1 - t) +
                                            static_cast<float>(kFloorColour[c]) * t + 0.5F);
    }
    picture.fill(0, row, picture.columns, 1, colour);
  }
}

void draw_centred(const Picture& picture, std::int64_t centre, std::int64_t top, std::string_view text,
                  const TextStyle& style) {
  draw_text(picture, centre - text_width(text, style) / 2, top, text, style);
}

/// The part of a text that fits into `pixels`.
std::string_view cut(std::string_view text, std::uint32_t pixels, const TextStyle& style) {
  return text.substr(0, std::min<std::size_t>(text.size(), pixels / style.advance()));
}

/// A bar of a round length: 1, 2 or 5 times a power of ten, as long as possible but not above 200 pixels.
void draw_scale_bar(const Picture& picture, double pixels_per_mm, std::int64_t left, std::int64_t top) {
  double length = 0.01;
  for (const double factor : {1.0, 10.0, 100.0, 1000.0, 10000.0}) {
    for (const double digit : {0.01, 0.02, 0.05}) {
      if (digit * factor * pixels_per_mm <= 200.0) length = digit * factor;
    }
  }
  const auto pixels = static_cast<std::int64_t>(length * pixels_per_mm + 0.5);
  picture.fill(left, top + 5, pixels, 3, kInk);
  picture.fill(left, top, 2, 13, kInk);
  picture.fill(left + pixels - 2, top, 2, 13, kInk);
  char label[32];
  std::snprintf(label, sizeof label, "%g mm", length);
  draw_text(picture, left + pixels + 14, top, label, {.scale = 2, .colour = kInk});
}

/// A line under a view, fading out at both ends, for the object to stand on.
void draw_floor(const Picture& picture, std::int64_t left, std::int64_t width, std::int64_t row) {
  constexpr std::int64_t kFade = 40;
  for (std::int64_t x = -kFade; x < width + kFade; ++x) {
    const std::int64_t inside = std::min(x + kFade, width + kFade - x);
    const float cover = std::min(static_cast<float>(inside) / kFade, 1.0F);
    picture.blend(left + x, row, kLine, cover);
    picture.blend(left + x, row + 1, kLine, 0.4F * cover);
  }
}

}  // namespace

std::size_t preview_bytes(const PrintGrid& grid) {
  return Arena::rounded(BitImage::words_needed(grid.columns, grid.rows) * sizeof(std::uint64_t)) +
         Arena::rounded(std::size_t{std::max(grid.columns, grid.rows)} * sizeof(std::uint32_t)) +
         Arena::rounded(std::size_t{(grid.columns + 63) / 64} * sizeof(std::uint64_t)) +
         Arena::rounded(height_cells(grid) * sizeof(std::uint16_t)) + 2 * Arena::rounded(kSamples * sizeof(float));
}

Status draw_preview(const RRep& rrep, const PreviewText& text, Arena& arena, std::span<std::uint8_t> rgb) {
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
  const auto depths = arena.take_top<float>(kSamples, kStage);
  PLUMBLINE_TRY(depths);
  const auto scratch = arena.take_top<float>(kSamples, kStage);
  PLUMBLINE_TRY(scratch);

  const Picture picture{rgb, kPreviewColumns, kPreviewRows};
  draw_background(picture);
  const TextStyle title{.scale = 4, .colour = kInk}, plain{.scale = 2, .colour = kInk},
      pale{.scale = 2, .colour = kPaleInk};
  char facts[128] = "empty";

  const Extent extent = find_extent(rrep, *words);
  if (!extent.empty()) {
    const Layout layout(extent, grid);
    std::span<float> rest = *depths;
    const auto take_map = [&](std::uint32_t width, std::uint32_t height) {
      const std::uint32_t columns = width * kSamplesPerPixel, rows = height * kSamplesPerPixel;
      const DepthMap map{rest.first(std::size_t{columns} * rows), columns, rows};
      rest = rest.subspan(map.depth.size());
      std::fill(map.depth.begin(), map.depth.end(), DepthMap::kEmpty);
      return map;
    };
    const DepthMap front = take_map(layout.width, layout.height), side = take_map(layout.depth, layout.height),
                   top = take_map(layout.width, layout.depth);
    Section section(rrep, *words);
    Surveyor(rrep, extent, layout).survey(section, *nearest, *found, *heights, front, side, top);

    const auto smooth = [&](const DepthMap& map, float across_mm, float up_mm, float deep_mm) {
      const auto samples = [&](float mm) { return std::max(1.0F, mm * static_cast<float>(layout.samples_per_mm())); };
      smooth_depth(map, *scratch, {.across = samples(std::max(across_mm, up_mm)), .deep = samples(deep_mm)});
    };
    smooth(front, grid.pitch_x_mm, grid.layer_height_mm, grid.pitch_y_mm);
    smooth(side, grid.pitch_y_mm, grid.layer_height_mm, grid.pitch_x_mm);
    smooth(top, grid.pitch_x_mm, grid.pitch_y_mm, grid.layer_height_mm);

    const std::int64_t upper = layout.floor - layout.height;
    const std::int64_t top_upper = layout.floor - (std::int64_t{layout.tall} + layout.depth) / 2;
    draw_floor(picture, layout.front_left, layout.width, layout.floor);
    draw_floor(picture, layout.side_left, layout.depth, layout.floor);
    shade_depth(front, picture, layout.front_left, upper, kMaterial);
    shade_depth(side, picture, layout.side_left, upper, kMaterial);
    shade_depth(top, picture, layout.top_left, top_upper, kMaterial);

    const std::int64_t label = layout.floor + 18;
    draw_centred(picture, layout.front_left + layout.width / 2, label, "front", pale);
    draw_centred(picture, layout.side_left + layout.depth / 2, label, "side", pale);
    draw_centred(picture, layout.top_left + layout.width / 2, label, "top", pale);
    draw_scale_bar(picture, layout.pixels_per_mm, kMargin, 106);
    std::snprintf(facts, sizeof facts, "%.1f x %.1f x %.1f mm    %u layers of %g mm", layout.width_mm, layout.depth_mm,
                  layout.height_mm, extent.layer_end - extent.layer, double{grid.layer_height_mm});
  }

  const std::uint32_t facts_width = text_width(facts, plain);
  draw_text(picture, std::int64_t{kPreviewColumns} - kMargin - facts_width, 52, facts, plain);
  draw_text(picture, kMargin, 38, cut(text.name, kPreviewColumns - 3 * kMargin - facts_width, title), title);
  std::int64_t line = 806;
  for (const auto caption : text.captions.first(std::min(text.captions.size(), kMaxPreviewCaptions))) {
    draw_text(picture, kMargin, line, cut(caption, kPreviewColumns - 2 * kMargin, pale), pale);
    line += 28;
  }
  return {};
}

Expected<std::span<const std::byte>> encode_preview(const RRep& rrep, const PreviewText& text, Arena& arena,
                                                    PngEncoder& encoder) {
  const ArenaScope scope(arena);
  const auto rgb = arena.take_top<std::uint8_t>(std::size_t{3} * kPreviewColumns * kPreviewRows, "preview");
  PLUMBLINE_TRY(rgb);
  PLUMBLINE_TRY(draw_preview(rrep, text, arena, *rgb));
  return encoder.encode(*rgb, kPreviewColumns, kPreviewRows);
}

}  // namespace plumbline
