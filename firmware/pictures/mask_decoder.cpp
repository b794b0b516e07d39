#include "firmware/pictures/mask_decoder.hpp"

#include <algorithm>
#include <bit>
#include <cstring>
#include <memory>
#include <new>

namespace plumbline::firmware::inline pictures {
namespace {

/// The highest bit of the first channel of each pixel: the upper half of its levels.
/// @param line  as the file has it, `step` bytes a pixel or `depth` bits
/// @param bits  one word for each 64 pixels
void threshold(std::span<const unsigned char> line, std::uint32_t columns, std::size_t depth, std::size_t step,
               std::span<std::uint64_t> bits) {
  for (std::uint32_t column = 0; column < columns; column += 64) {
    const std::uint32_t end = std::min(columns - column, 64U);
    std::uint64_t word = 0;
    for (std::uint32_t i = 0; i < end; ++i) {
      const std::uint32_t at = column + i;
      const unsigned level = depth < 8 ? unsigned{line[at * depth / 8]} << (at * depth % 8) : line[at * step];
      word |= std::uint64_t{(level >> 7U) & 1U} << i;
    }
    bits[column / 64] = word;
  }
}

/// Whether a level that lies on black with an opacity is in the upper half. Both have 8 bits, or are the upper 8 of 16.
bool shows(unsigned level, unsigned opacity) { return level * opacity >= 128U * 255U; }

/// Counts a pixel, whose level is white at `full`.
void count_grey(std::uint64_t level, std::uint64_t full, bool shown, GreyShare& grey) {
  if (level == 0) return;
  ++grey.lit;
  grey.grey += level < full ? 1 : 0;
  grey.lost += shown ? 0 : 1;
}

/// The same of grey with opacity.
void threshold_grey_with_opacity(std::span<const unsigned char> line, std::uint32_t columns, std::size_t step,
                                 std::span<std::uint64_t> bits, GreyShare* grey) {
  std::fill(bits.begin(), bits.end(), 0);
  for (std::uint32_t column = 0; column < columns; ++column) {
    const unsigned char* const at = &line[step * column];
    const bool shown = shows(at[0], at[step / 2]);
    bits[column / 64] |= std::uint64_t{shown ? 1U : 0U} << (column % 64);
    if (grey != nullptr) count_grey(std::uint64_t{at[0]} * at[step / 2], 255U * 255U, shown, *grey);
  }
}

/// The same of colours: red, green, blue and opacity, 8 bits each.
void threshold_colours(std::span<const unsigned char> line, std::uint32_t columns, std::span<std::uint64_t> bits,
                       GreyShare* grey) {
  std::fill(bits.begin(), bits.end(), 0);
  for (std::uint32_t column = 0; column < columns; ++column) {
    const unsigned char* const at = &line[std::size_t{4} * column];
    const unsigned luma = 299U * at[0] + 587U * at[1] + 114U * at[2];
    const bool shown = luma * at[3] >= 128'000U * 255U;
    bits[column / 64] |= std::uint64_t{shown ? 1U : 0U} << (column % 64);
    if (grey != nullptr) count_grey(std::uint64_t{luma} * at[3], 255'000U * 255U, shown, *grey);
  }
}

/// Counts the pixels of a row without opacity. Few pixels of a mask are grey: eight at a time are looked at.
/// @param depth, step  as those of threshold()
void count_grey(std::span<const unsigned char> line, std::uint32_t columns, std::size_t depth, std::size_t step,
                GreyShare& grey) {
  const unsigned white = depth < 8 ? (1U << depth) - 1 : 255;
  for (std::uint32_t column = 0; column < columns; ++column) {
    if (depth == 8 && columns - column >= 8) {
      std::uint64_t eight = 0;
      std::memcpy(&eight, &line[column], sizeof eight);
      const bool lit = ~eight == 0;
      if (eight == 0 || lit) {
        grey.lit += lit ? 8 : 0;
        column += 7;
        continue;
      }
    }
    const std::size_t bit = std::size_t{column} * depth % 8;
    const unsigned level = depth < 8 ? (line[column * depth / 8] >> (8 - depth - bit)) & white : line[column * step];
    grey.lit += level > 0 ? 1 : 0;
    if (level == 0 || level == white) continue;
    ++grey.grey;
    grey.lost += 2 * level < white ? 1 : 0;
  }
}

/// Adds a row of the file where it lies on the plate.
void place(std::span<const std::uint64_t> bits, std::uint32_t row, const MaskTurn& turn, BitImage out) {
  const std::uint32_t columns = turn.swaps ? out.rows() : out.columns();
  const std::uint32_t rows = turn.swaps ? out.columns() : out.rows();
  const std::uint32_t across = turn.mirror_y ? rows - 1 - row : row;
  if (!turn.mirror_x && !turn.swaps) {
    const auto row_of_out = out.row(across);
    for (std::size_t w = 0; w < bits.size(); ++w) row_of_out[w] |= bits[w];
    return;
  }
  for (std::size_t w = 0; w < bits.size(); ++w) {
    for (std::uint64_t rest = bits[w]; rest != 0; rest &= rest - 1) {
      const auto column = static_cast<std::uint32_t>(64 * w) + static_cast<std::uint32_t>(std::countr_zero(rest));
      const std::uint32_t along = turn.mirror_x ? columns - 1 - column : column;
      if (turn.swaps) {
        out.set(across, along);
      } else {
        out.set(along, across);
      }
    }
  }
}

}  // namespace

std::uint64_t most_mask_bytes(std::uint32_t columns, std::uint32_t rows) {
  constexpr std::uint64_t kRest = 65536;  // header, texts, frames of the chunks
  const std::uint64_t raw = (std::uint64_t{8} * columns + 2) * rows;
  return raw + raw / 64 + kRest;
}

Status decode_turned_mask(PngBytes bytes, std::uint64_t most_bytes, const MaskTurn& turn, BitImage out,
                          GreyShare* grey) {
  const std::uint32_t columns = turn.swaps ? out.rows() : out.columns();
  const std::uint32_t rows = turn.swaps ? out.columns() : out.rows();
  out.clear();
  PngRows file(bytes, most_bytes);
  const auto header = file.header();
  PLUMBLINE_TRY(header);
  if (header->columns != columns || header->rows != rows) {
    return fail(ErrorCode::kMalformed, "has %u x %u pixels, the first layer %u x %u.\tExport the layers again",
                header->columns, header->rows, columns, rows);
  }
  const std::size_t line_bytes =
      header->is_grey ? (header->channels * header->depth * columns + 7) / 8 : std::size_t{4} * columns;
  const std::unique_ptr<unsigned char[]> line(new (std::nothrow) unsigned char[line_bytes]);
  const std::size_t words = (columns + std::size_t{63}) / 64;
  const std::unique_ptr<std::uint64_t[]> bits(new (std::nothrow) std::uint64_t[words]);
  if (!line || !bits) return fail(ErrorCode::kOutOfMemory, "no memory for its rows");
  PLUMBLINE_TRY(file.begin(header->is_grey ? PngRows::Form::kAsStored : PngRows::Form::kRgba));
  while (file.rows_left() > 0) {
    // Pixels that another pass has are black, which place() adds.
    if (header->is_interlaced) std::memset(line.get(), 0, line_bytes);
    const auto row = file.next({line.get(), line_bytes});
    PLUMBLINE_TRY(row);
    if (header->is_grey && header->channels == 2) {
      threshold_grey_with_opacity({line.get(), line_bytes}, columns, header->depth / std::size_t{4},
                                  {bits.get(), words}, grey);
    } else if (header->is_grey) {
      threshold({line.get(), line_bytes}, columns, header->depth, header->depth / std::size_t{8}, {bits.get(), words});
      if (grey != nullptr) {
        count_grey({line.get(), line_bytes}, columns, header->depth, header->depth / std::size_t{8}, *grey);
      }
    } else {
      threshold_colours({line.get(), line_bytes}, columns, {bits.get(), words}, grey);
    }
    place({bits.get(), words}, *row, turn, out);
  }
  return file.finish();
}

Status decode_mask(std::span<const std::byte> file, BitImage out) {
  BytesOf bytes{file};
  return decode_turned_mask(bytes, UINT64_MAX, {}, out);
}

}  // namespace plumbline::firmware::inline pictures
