#include "firmware/pictures/job_pictures.hpp"

#include <algorithm>
#include <bit>

#include "firmware/pictures/coverage_views.hpp"
#include "firmware/pictures/preview.hpp"
#include "firmware/pictures/preview_layout.hpp"

namespace plumbline {
namespace {

/// Pixels around the views that stay on the picture.
constexpr std::int64_t kRim = 12;

/// Part of a page that is reduced to a picture.
using Part = preview::PagePart;

/// The three views of a page, without the texts around them; or the front view alone.
Part views_of(const RRep& rrep, const Supports& supports, bool front_only, std::span<std::uint64_t> words) {
  const preview::Extent object = preview::find_extent(rrep, words);
  if (object.empty()) return {};
  const preview::Layout page = preview::lay_out(preview::with_supports(object, supports, rrep.grid), rrep.grid);
  const std::int64_t left = std::max<std::int64_t>(page.front_left - kRim, 0);
  const std::int64_t end = (front_only ? page.front_left : page.top_left) + page.width + kRim;
  const std::int64_t right = std::min<std::int64_t>(end, kPreviewColumns);
  // The scale's bar ends above, and the views' names begin below.
  const std::int64_t tall = front_only ? page.height : page.tall;
  const std::int64_t top = std::max<std::int64_t>(page.floor - tall - kRim, preview::kTop);
  const std::int64_t bottom = std::min<std::int64_t>(page.floor + kRim, kPreviewRows);
  return {static_cast<std::uint32_t>(left), static_cast<std::uint32_t>(top), static_cast<std::uint32_t>(right - left),
          static_cast<std::uint32_t>(bottom - top)};
}

/// Pixels [begin, end) of a part's side that pixel `i` of a picture's side shows.
struct Stretch {
  std::uint32_t begin = 0, end = 0;
  bool beyond = false;  ///< the picture goes on there, and the part does not
};

/// The part's middle is the picture's.
/// @param shown  pixels of the picture's side that the part fills, 1 to `side`
Stretch stretch_of(std::uint32_t i, std::uint32_t side, std::uint32_t shown, std::uint32_t part) {
  const std::uint32_t before = (side - shown) / 2;
  const std::uint32_t at = i < before ? 0 : std::min(i - before, shown - 1);
  const auto begin = static_cast<std::uint32_t>(std::uint64_t{at} * part / shown);
  const auto end = static_cast<std::uint32_t>((std::uint64_t{at} + 1) * part / shown);
  return {begin, std::max(begin + 1, end), i < before || i - before >= shown};
}

struct Size {
  std::uint32_t columns = 0, rows = 0;
};

/// As large as the picture allows at the part's proportions.
Size fitted(const Part& part, Size picture) {
  if (std::uint64_t{part.columns} * picture.rows >= std::uint64_t{part.rows} * picture.columns) {
    return {picture.columns, std::max(1U, picture.columns * part.rows / part.columns)};
  }
  return {std::max(1U, picture.rows * part.columns / part.rows), picture.rows};
}

/// Means over the part's pixels.
/// @param shown  pixels in the picture's middle that the part fills
void reduce(std::span<const std::uint8_t> page, const Part& part, Size shown, Size picture,
            std::span<std::uint8_t> out) {
  for (std::uint32_t y = 0; y < picture.rows; ++y) {
    const Stretch down = stretch_of(y, picture.rows, shown.rows, part.rows);
    for (std::uint32_t x = 0; x < picture.columns; ++x) {
      const Stretch across = stretch_of(x, picture.columns, shown.columns, part.columns);
      // Each row of the page begins with background.
      const bool beyond = down.beyond || across.beyond;
      const std::size_t left = beyond ? 0 : std::size_t{part.left} + across.begin;
      const std::size_t right = beyond ? 1 : std::size_t{part.left} + across.end;
      std::array<std::uint32_t, 3> sum{};
      for (std::uint32_t r = down.begin; r < down.end; ++r) {
        for (std::size_t c = left; c < right; ++c) {
          const std::size_t at = 3 * (std::size_t{part.top + r} * kPreviewColumns + c);
          for (std::size_t channel = 0; channel < 3; ++channel) sum[channel] += page[at + channel];
        }
      }
      const std::size_t count = (down.end - down.begin) * (right - left);
      for (std::size_t channel = 0; channel < 3; ++channel) {
        out[3 * (std::size_t{y} * picture.columns + x) + channel] = static_cast<std::uint8_t>(sum[channel] / count);
      }
    }
  }
}

/// The page with the views, and the part of it that is shown.
struct DrawnPage {
  std::span<const std::uint8_t> rgb;  ///< at the arena's top
  Part part;
};

Expected<DrawnPage> draw_page(const RRep& rrep, const Supports& supports, bool front_only, Arena& arena) {
  const auto rgb = arena.take_top<std::uint8_t>(std::size_t{3} * kPreviewColumns * kPreviewRows, "preview");
  PLUMBLINE_TRY(rgb);
  PLUMBLINE_TRY(draw_preview(rrep, supports, {}, arena, *rgb));
  const auto words =
      arena.take_top<std::uint64_t>(BitImage::words_needed(rrep.grid.columns, rrep.grid.rows), "preview");
  PLUMBLINE_TRY(words);
  return DrawnPage{*rgb, views_of(rrep, supports, front_only, *words)};
}

/// Pixels that are set among `count` from `begin` on; at most 64.
std::uint32_t count_bits(std::span<const std::uint64_t> row, std::uint32_t begin, std::uint32_t count) {
  const std::size_t word = begin / 64;
  const std::uint32_t shift = begin % 64;
  std::uint64_t bits = row[word] >> shift;
  if (shift > 0 && word + 1 < row.size()) bits |= row[word + 1] << (64 - shift);
  if (count < 64) bits &= (std::uint64_t{1} << count) - 1;
  return static_cast<std::uint32_t>(std::popcount(bits));
}

/// The part of a page as a picture, as large as it can be at the part's proportions.
template <class Picture>
void fill_from(std::span<const std::uint8_t> page, const Part& part, Picture& picture) {
  if (part.columns == 0 || part.rows == 0) return;
  picture.columns = std::min(Picture::kMostColumns, Picture::kMostRows * part.columns / part.rows);
  picture.columns = std::clamp(picture.columns, 1U, part.columns);
  picture.rows = std::clamp(picture.columns * part.rows / part.columns, 1U, Picture::kMostRows);
  const Size size{picture.columns, picture.rows};
  reduce(page, part, size, size, picture.bytes());
  keep_five_bits(picture.bytes());
}

}  // namespace

void keep_five_bits(std::span<std::uint8_t> levels) {
  for (std::uint8_t& level : levels) level = static_cast<std::uint8_t>((level & 0xF8U) | level >> 5U);
}

Status draw_preview_picture(const RRep& rrep, const Supports& supports, Arena& arena, PreviewPicture& picture) {
  picture.clear();
  const ArenaScope scope(arena);
  const auto page = draw_page(rrep, supports, false, arena);
  PLUMBLINE_TRY(page);
  fill_from(page->rgb, page->part, picture);
  return {};
}

Status draw_coverage_picture(const RRep& rrep, const ConfidenceMap& map, Arena& arena, CoveragePicture& picture) {
  picture.clear();
  if (map.empty()) return {};
  const ArenaScope scope(arena);
  const auto rgb = arena.take_top<std::uint8_t>(std::size_t{3} * kPreviewColumns * kPreviewRows, "coverage picture");
  PLUMBLINE_TRY(rgb);
  const auto part = preview::draw_coverage_views(rrep, map, arena, *rgb);
  PLUMBLINE_TRY(part);
  fill_from(*rgb, *part, picture);
  return {};
}

Expected<std::span<const std::uint8_t>> draw_thumbnail(const RRep& rrep, const Supports& supports,
                                                       std::uint32_t columns, std::uint32_t rows, Arena& arena) {
  const auto rgb = arena.take_top<std::uint8_t>(std::size_t{3} * columns * rows, "thumbnail");
  PLUMBLINE_TRY(rgb);
  std::fill(rgb->begin(), rgb->end(), std::uint8_t{0});
  const ArenaScope scope(arena);
  const auto page = draw_page(rrep, supports, columns <= rows, arena);
  PLUMBLINE_TRY(page);
  const Size size{columns, rows};
  if (page->part.columns > 0 && page->part.rows > 0) {
    reduce(page->rgb, page->part, fitted(page->part, size), size, *rgb);
  }
  return *rgb;
}

void draw_layer_picture(ConstBitImage mask, LayerPicture& picture) {
  const std::uint32_t longest = std::max(mask.columns(), mask.rows());
  // At most 64, since a grid has at most 16384 pixels a side.
  const std::uint32_t side = (longest + LayerPicture::kMostColumns - 1) / LayerPicture::kMostColumns;
  picture.columns = (mask.columns() + side - 1) / side;
  picture.rows = (mask.rows() + side - 1) / side;
  const std::span<std::uint8_t> out = picture.bytes();
  std::array<std::uint32_t, LayerPicture::kMostColumns> sums{};
  for (std::uint32_t y = 0; y < picture.rows; ++y) {
    sums.fill(0);
    const std::uint32_t end = std::min((y + 1) * side, mask.rows());
    for (std::uint32_t r = y * side; r < end; ++r) {
      const auto row = mask.row(r);
      for (std::uint32_t x = 0; x < picture.columns; ++x) {
        sums[x] += count_bits(row, x * side, std::min(side, mask.columns() - x * side));
      }
    }
    for (std::uint32_t x = 0; x < picture.columns; ++x) {
      const std::uint32_t pixels = (end - y * side) * std::min(side, mask.columns() - x * side);
      out[std::size_t{y} * picture.columns + x] = static_cast<std::uint8_t>((sums[x] * 255 + pixels / 2) / pixels);
    }
  }
}

}  // namespace plumbline
