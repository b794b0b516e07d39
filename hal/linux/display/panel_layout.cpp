#include "hal/linux/display/panel_layout.hpp"

#include <algorithm>
#include <array>
#include <cassert>

namespace plumbline {
namespace {

constexpr std::uint32_t kWhite = 0x00FFFFFF;
/// By three bits, the first neighbour the lowest: red is the highest byte of the three.
constexpr std::array<std::uint32_t, 8> kForward = {0x000000, 0xFF0000, 0x00FF00, 0xFFFF00,
                                                   0x0000FF, 0xFF00FF, 0x00FFFF, 0xFFFFFF};
constexpr std::array<std::uint32_t, 8> kBackward = {0x000000, 0x0000FF, 0x00FF00, 0x00FFFF,
                                                    0xFF0000, 0xFF00FF, 0xFFFF00, 0xFFFFFF};

/// Three bits of a row from `at` on.
std::size_t three(std::span<const std::uint64_t> row, std::uint32_t at) {
  const std::uint32_t shift = at % 64;
  std::uint64_t bits = row[at / 64] >> shift;
  if (shift > 61) bits |= row[at / 64 + 1] << (64 - shift);
  return static_cast<std::size_t>(bits & 7U);
}

/// A row that lies as it does in the mask, or the other way round.
void pack_row(std::span<const std::uint64_t> row, std::uint32_t columns, bool rgb, bool backward,
              std::span<std::uint32_t> out) {
  if (rgb) {
    const auto& colours = backward ? kBackward : kForward;
    for (std::uint32_t i = 0; i < out.size(); ++i) {
      out[i] = colours[three(row, backward ? columns - 3 * (i + 1) : 3 * i)];
    }
    return;
  }
  for (std::uint32_t i = 0; i < out.size(); ++i) {
    const std::uint32_t at = backward ? columns - 1 - i : i;
    out[i] = (row[at / 64] >> (at % 64)) & 1U ? kWhite : 0;
  }
}

/// A row that is a column of the mask, read downwards or upwards.
void pack_column(ConstBitImage mask, std::uint32_t column, bool rgb, bool upward, std::span<std::uint32_t> out) {
  std::uint32_t row = upward ? mask.rows() - 1 : 0;
  const std::uint32_t next = upward ? ~0U : 1U;
  for (auto& pixel : out) {
    if (!rgb) {
      pixel = mask.at(column, row) ? kWhite : 0;
      row += next;
      continue;
    }
    std::size_t bits = 0;
    for (unsigned i = 0; i < 3; ++i, row += next) bits |= static_cast<std::size_t>(mask.at(column, row)) << i;
    pixel = kForward[bits];
  }
}

}  // namespace

Status PanelLayout::check() const {
  if (rgb && picture_width() % 3 != 0) {
    return fail(ErrorCode::kBadSetting,
                "the panel packs three pixels of a row into one, but has %u of them a row as it is turned",
                picture_width());
  }
  return {};
}

void pack_pixels(const PanelLayout& layout, ConstBitImage mask, std::span<std::uint32_t> pixels, std::size_t pitch) {
  assert(mask.columns() == layout.columns && mask.rows() == layout.rows && pitch >= layout.mode_width());
  const bool flip_x = layout.mirror == PanelLayout::Mirror::kX;
  const bool flip_y = layout.mirror == PanelLayout::Mirror::kY;
  const std::uint32_t height = layout.mode_height();
  for (std::uint32_t r = 0; r < height; ++r) {
    const auto row = pixels.subspan(r * pitch, pitch);
    const auto out = row.first(layout.mode_width());
    const std::uint32_t turned = flip_y ? height - 1 - r : r;  // the row of the turned picture
    switch (layout.rotation_deg) {
      case 90:  // its top row is the mask's rightmost column, read downwards
        pack_column(mask, layout.columns - 1 - turned, layout.rgb, flip_x, out);
        break;
      case 180: pack_row(mask.row(layout.rows - 1 - turned), layout.columns, layout.rgb, !flip_x, out); break;
      case 270:  // the leftmost column, read upwards
        pack_column(mask, turned, layout.rgb, !flip_x, out);
        break;
      default: pack_row(mask.row(turned), layout.columns, layout.rgb, flip_x, out); break;
    }
    std::fill(row.begin() + static_cast<std::ptrdiff_t>(out.size()), row.end(), 0U);
  }
}

}  // namespace plumbline
