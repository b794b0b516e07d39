#include "firmware/pictures/job_pictures.hpp"

#include <algorithm>
#include <bit>

#include "firmware/pictures/preview.hpp"
#include "firmware/pictures/preview_layout.hpp"

namespace plumbline {
namespace {

/// Pixels around the views that stay on the picture.
constexpr std::int64_t kRim = 12;

/// Part of a page that is reduced to a picture.
struct Part {
  std::uint32_t left = 0, top = 0, columns = 0, rows = 0;
};

/// The three views of a page, without the texts around them.
Part views_of(const RRep& rrep, const Supports& supports, std::span<std::uint64_t> words) {
  const preview::Extent object = preview::find_extent(rrep, words);
  if (object.empty()) return {};
  const preview::Layout page = preview::lay_out(preview::with_supports(object, supports, rrep.grid), rrep.grid);
  const std::int64_t left = std::max<std::int64_t>(page.front_left - kRim, 0);
  const std::int64_t right = std::min<std::int64_t>(page.top_left + page.width + kRim, kPreviewColumns);
  // The scale's bar ends above, and the views' names begin below.
  const std::int64_t top = std::max<std::int64_t>(page.floor - page.tall - kRim, preview::kTop);
  const std::int64_t bottom = std::min<std::int64_t>(page.floor + kRim, kPreviewRows);
  return {static_cast<std::uint32_t>(left), static_cast<std::uint32_t>(top), static_cast<std::uint32_t>(right - left),
          static_cast<std::uint32_t>(bottom - top)};
}

/// Means over the part's pixels, as large as the picture's memory allows at the part's proportions.
void reduce(std::span<const std::uint8_t> page, const Part& part, PreviewPicture& picture) {
  picture.columns = std::min(PreviewPicture::kMostColumns, PreviewPicture::kMostRows * part.columns / part.rows);
  picture.columns = std::clamp(picture.columns, 1U, part.columns);
  picture.rows = std::clamp(picture.columns * part.rows / part.columns, 1U, PreviewPicture::kMostRows);
  const std::span<std::uint8_t> out = picture.bytes();
  for (std::uint32_t y = 0; y < picture.rows; ++y) {
    const std::uint32_t top = y * part.rows / picture.rows;
    const std::uint32_t bottom = std::max(top + 1, (y + 1) * part.rows / picture.rows);
    for (std::uint32_t x = 0; x < picture.columns; ++x) {
      const std::uint32_t left = x * part.columns / picture.columns;
      const std::uint32_t right = std::max(left + 1, (x + 1) * part.columns / picture.columns);
      std::array<std::uint32_t, 3> sum{};
      for (std::uint32_t r = top; r < bottom; ++r) {
        for (std::uint32_t c = left; c < right; ++c) {
          const std::size_t at = 3 * (std::size_t{part.top + r} * kPreviewColumns + part.left + c);
          for (std::size_t channel = 0; channel < 3; ++channel) sum[channel] += page[at + channel];
        }
      }
      const std::uint32_t count = (bottom - top) * (right - left);
      for (std::size_t channel = 0; channel < 3; ++channel) {
        const auto mean = static_cast<std::uint8_t>(sum[channel] / count);
        // 5 bits, as many as a small screen shows: the picture's PNG has to fit a line of the state socket.
        out[3 * (std::size_t{y} * picture.columns + x) + channel] =
            static_cast<std::uint8_t>((mean & 0xF8U) | mean >> 5U);
      }
    }
  }
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

}  // namespace

Status draw_preview_picture(const RRep& rrep, const Supports& supports, Arena& arena, PreviewPicture& picture) {
  picture.clear();
  const ArenaScope scope(arena);
  const auto rgb = arena.take_top<std::uint8_t>(std::size_t{3} * kPreviewColumns * kPreviewRows, "preview");
  PLUMBLINE_TRY(rgb);
  PLUMBLINE_TRY(draw_preview(rrep, supports, {}, arena, *rgb));
  const auto words =
      arena.take_top<std::uint64_t>(BitImage::words_needed(rrep.grid.columns, rrep.grid.rows), "preview");
  PLUMBLINE_TRY(words);
  const Part part = views_of(rrep, supports, *words);
  if (part.columns > 0 && part.rows > 0) reduce(*rgb, part, picture);
  return {};
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
