#include "firmware/pictures/job_pictures.hpp"

#include <algorithm>

#include "firmware/pictures/mask_squares.hpp"
#include "firmware/pictures/png.hpp"
#include "firmware/pictures/preview/preview_views.hpp"

namespace plumbline::firmware::inline pictures {

using namespace preview;

namespace {

// A page of the picture's own size: a full page that is reduced afterwards costs over ten times as much.
constexpr Page kSmallPreview = page_of_views(PreviewPicture::kMostColumns, PreviewPicture::kMostRows, 20);

/// The largest picture, in the memory of one that may be smaller.
template <class Small>
Picture whole(Small& picture) {
  return {picture.memory, Small::kMostColumns, Small::kMostRows};
}

/// Keeps a part of the largest picture. A side that only rounding has left shorter stays whole.
template <class Small>
void keep_part(Small& picture, PagePart part) {
  constexpr std::uint32_t kRounding = 6;
  if (part.columns + kRounding > Small::kMostColumns) {
    part.left = 0;
    part.columns = Small::kMostColumns;
  }
  if (part.rows + kRounding > Small::kMostRows) {
    part.top = 0;
    part.rows = Small::kMostRows;
  }
  constexpr std::size_t kRow = Small::kChannels * Small::kMostColumns;
  picture.columns = part.columns;
  picture.rows = part.rows;
  for (std::uint32_t row = 0; row < part.rows; ++row) {
    const auto from =
        picture.memory.begin() + static_cast<std::ptrdiff_t>((part.top + row) * kRow + Small::kChannels * part.left);
    std::copy_n(from, Small::kChannels * part.columns,
                picture.bytes().begin() + static_cast<std::ptrdiff_t>(Small::kChannels * row * part.columns));
  }
  keep_five_bits(picture.bytes());
}

}  // namespace

void keep_five_bits(std::span<std::uint8_t> levels) {
  for (std::uint8_t& level : levels) level = static_cast<std::uint8_t>((level & 0xF8U) | level >> 5U);
}

std::size_t preview_picture_bytes(const PrintGrid& grid) {
  return views_bytes(grid, kSmallPreview, Views::kThreeSides);
}

Status draw_preview_picture(const RRep& rrep, const Supports& supports, Arena& arena, PreviewPicture& picture) {
  picture.clear();
  const auto layout = draw_views(rrep, supports, kSmallPreview, Views::kThreeSides, arena, whole(picture));
  PLUMBLINE_TRY(layout);
  if (*layout) {
    const Layout& at = **layout;
    const auto left = static_cast<std::uint32_t>(at.front_left) - kRim;
    const auto right = static_cast<std::uint32_t>(at.top_left) + at.width + kRim;
    const auto bottom = static_cast<std::uint32_t>(at.floor) + kRim;
    keep_part(picture, {left, bottom - at.tall - 2 * kRim, right - left, at.tall + 2 * kRim});
  }
  return {};
}

Expected<std::span<std::uint8_t>> draw_thumbnail(const RRep& rrep, const Supports& supports, std::uint32_t columns,
                                                 std::uint32_t rows, Arena& arena) {
  const auto memory = arena.take_top<std::uint8_t>(picture_bytes(columns, rows), "thumbnail");
  PLUMBLINE_TRY(memory);
  const Page page = page_of_views(columns, rows, columns / 16);
  const auto views = columns <= rows ? Views::kFront : Views::kThreeSides;
  const auto drawn = draw_views(rrep, supports, page, views, arena, {*memory, columns, rows});
  PLUMBLINE_TRY(drawn);
  if (!*drawn) std::fill(memory->begin(), memory->end(), std::uint8_t{0});
  return *memory;
}

void draw_layer_picture(ConstBitImage mask, const PartBox& part, LayerPicture& picture) {
  PartBox shown{0, 0, mask.columns(), mask.rows()};
  if (part.columns > 0 && part.rows > 0 && part.column < mask.columns() && part.row < mask.rows()) {
    const std::uint32_t wide = std::min(part.columns, mask.columns()), deep = std::min(part.rows, mask.rows());
    const std::uint32_t around = std::max(wide, deep) / 12;
    shown.column = part.column - std::min(part.column, around);
    shown.row = part.row - std::min(part.row, around);
    shown.columns = std::min(wide + 2 * around, mask.columns() - shown.column);
    shown.rows = std::min(deep + 2 * around, mask.rows() - shown.row);
  }
  const MaskSquares squares =
      squares_of(shown.column, shown.row, shown.columns, shown.rows, LayerPicture::kMostColumns);
  picture.columns = squares.columns;
  picture.rows = squares.rows;
  const std::span<std::uint8_t> out = picture.bytes();
  for_each_square(
      mask, squares, [&](std::uint32_t row, std::size_t word) { return mask.row(row)[word]; },
      [&](std::uint32_t x, std::uint32_t y, std::uint32_t count, std::uint32_t pixels) {
        out[std::size_t{y} * picture.columns + x] = static_cast<std::uint8_t>((count * 255 + pixels / 2) / pixels);
      });
}

}  // namespace plumbline::firmware::inline pictures
