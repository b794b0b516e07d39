#include "hal/linux/display/pack_pixels.hpp"

#include <algorithm>
#include <array>
#include <cassert>
#include <tuple>

namespace plumbline::inline hal::inline linux_board {
namespace {

constexpr std::uint32_t kWhite = 0x00FFFFFF;
/// Pixel for three bits, the first neighbour the lowest bit: the first is red, the highest byte.
constexpr std::array<std::uint32_t, 8> kForward = {0x000000, 0xFF0000, 0x00FF00, 0xFFFF00,
                                                   0x0000FF, 0xFF00FF, 0x00FFFF, 0xFFFFFF};
constexpr std::array<std::uint32_t, 8> kBackward = {0x000000, 0x0000FF, 0x00FF00, 0x00FFFF,
                                                    0xFF0000, 0xFF00FF, 0xFFFF00, 0xFFFFFF};

/// Three bits of a row, starting at `at`.
std::size_t three_bits(std::span<const std::uint64_t> row, std::uint32_t at) {
  const std::uint32_t shift = at % 64;
  std::uint64_t bits = row[at / 64] >> shift;
  if (shift > 61) bits |= row[at / 64 + 1] << (64 - shift);
  return static_cast<std::size_t>(bits & 7U);
}

/// Packs a row of the mask, forward or backward.
void pack_row(std::span<const std::uint64_t> row, std::uint32_t columns, bool rgb, bool backward,
              std::span<std::uint32_t> out) {
  if (rgb) {
    const auto& colours = backward ? kBackward : kForward;
    for (std::uint32_t i = 0; i < out.size(); ++i) {
      out[i] = colours[three_bits(row, backward ? columns - 3 * (i + 1) : 3 * i)];
    }
    return;
  }
  for (std::uint32_t i = 0; i < out.size(); ++i) {
    const std::uint32_t at = backward ? columns - 1 - i : i;
    out[i] = (row[at / 64] >> (at % 64)) & 1U ? kWhite : 0;
  }
}

/// Packs a column of the mask, read downward or upward, as a row.
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

void pack_pixels(const PanelLayout& layout, ConstBitImage mask, std::span<std::uint32_t> pixels, std::size_t pitch) {
  assert(mask.columns() == layout.columns && mask.rows() == layout.rows && pitch >= layout.mode_width());
  const bool flip_x = layout.mirror == PanelLayout::Mirror::kX;
  const bool flip_y = layout.mirror == PanelLayout::Mirror::kY;
  const std::uint32_t height = layout.mode_height();
  for (std::uint32_t r = 0; r < height; ++r) {
    const auto row = pixels.subspan(r * pitch, pitch);
    const auto out = row.first(layout.mode_width());
    const std::uint32_t rotated = flip_y ? height - 1 - r : r;  // row of the rotated mask
    switch (layout.rotation_deg) {
      case 90:  // the top row is the mask's rightmost column, read downward
        pack_column(mask, layout.columns - 1 - rotated, layout.rgb, flip_x, out);
        break;
      case 180: pack_row(mask.row(layout.rows - 1 - rotated), layout.columns, layout.rgb, !flip_x, out); break;
      case 270:  // the top row is the leftmost column, read upward
        pack_column(mask, rotated, layout.rgb, !flip_x, out);
        break;
      default: pack_row(mask.row(rotated), layout.columns, layout.rgb, flip_x, out); break;
    }
    std::fill(row.begin() + static_cast<std::ptrdiff_t>(out.size()), row.end(), 0U);
  }
}

namespace {

/// Where the pixels of a mask's runs are in display memory.
class RunWriter {
 public:
  RunWriter(const PanelLayout& layout, std::span<std::uint32_t> pixels, std::size_t pitch)
      : layout_(layout), pixels_(pixels), bytes_(std::as_writable_bytes(pixels)), pitch_(pitch) {
    const auto origin = layout.sent({0, 0}), right = layout.sent({1, 0});
    step_x_ = right.column - origin.column;
    step_y_ = right.row - origin.row;
  }
  /// @param value_at  called with each column of the run, ascending
  template <class ValueAt>
  void write(const GreyRun& run, ValueAt value_at) const {
    const std::uint32_t column = run.pixel % layout_.columns, row = run.pixel / layout_.columns;
    auto to = layout_.sent({column, row});
    // Copies: display memory could be where members are, for all the compiler knows.
    const auto [pixels, bytes, pitch, rgb, step_x, step_y] =
        std::tuple(pixels_, bytes_, pitch_, layout_.rgb, step_x_, step_y_);
    for (std::uint32_t i = 0; i < run.count; ++i, to.column += step_x, to.row += step_y) {
      const std::uint32_t value = value_at(column + i);
      if (rgb) {  // little endian: blue, green, red
        bytes[4 * (to.row * pitch + to.column / 3) + 2 - to.column % 3] = static_cast<std::byte>(value);
      } else {
        pixels[to.row * pitch + to.column] = value * 0x010101U;
      }
    }
  }

 private:
  const PanelLayout& layout_;
  std::span<std::uint32_t> pixels_;
  std::span<std::byte> bytes_;
  std::size_t pitch_;
  std::uint32_t step_x_, step_y_;  ///< to the next pixel of a row of the mask: 0, 1 or ~0
};

}  // namespace

void pack_greys(const PanelLayout& layout, std::span<const GreyRun> runs, const GreyScale::Values& values,
                std::span<std::uint32_t> pixels, std::size_t pitch) {
  const RunWriter writer(layout, pixels, pitch);
  for (const GreyRun& run : runs) {
    const auto of_row = std::span(values[run.level]).subspan(4 * (run.pixel / layout.columns % 4), 4);
    writer.write(run, [of_row](std::uint32_t column) { return of_row[column % 4]; });
  }
}

void pack_evenly(const PanelLayout& layout, ConstBitImage mask, std::span<const GreyRun> runs, const LampShares& shares,
                 const GreyScale::Values& values, std::span<std::uint32_t> pixels, std::size_t pitch) {
  const RunWriter writer(layout, pixels, pitch);
  for_each_lit_run(mask, runs, shares, [&](const GreyRun& run, LampShares::Row& row) {
    const std::uint32_t of_row = 4 * (run.pixel / layout.columns % 4);
    writer.write(run, [&](std::uint32_t column) {
      return values[LampShares::scaled(run.level, row.next())][of_row + column % 4];
    });
  });
}

}  // namespace plumbline::inline hal::inline linux_board
