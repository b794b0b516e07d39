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

/// Where a pixel of the file lies on the plate.
struct Placed {
  Placed(const MaskTurn& how, BitImage image)
      : turn(how),
        columns(how.swaps ? image.rows() : image.columns()),
        rows(how.swaps ? image.columns() : image.rows()) {}

  MaskTurn turn;
  std::uint32_t columns, rows;  ///< of the file

  std::uint32_t along(std::uint32_t column) const { return turn.mirror_x ? columns - 1 - column : column; }
  std::uint32_t across(std::uint32_t row) const { return turn.mirror_y ? rows - 1 - row : row; }
  /// @returns row * columns + column there
  std::uint32_t pixel(std::uint32_t column, std::uint32_t row) const {
    return turn.swaps ? along(column) * rows + across(row) : across(row) * columns + along(column);
  }
};

/// Takes note of the pixels of a file that are neither black nor white.
class GreyPixels {
 public:
  GreyPixels(const Placed& placed, GreyShare* share, GreyRuns* greys)
      : placed_(placed), share_(share), greys_(greys != nullptr && greys->capacity() > 0 ? greys : nullptr) {
    if (greys != nullptr) greys->clear();
  }
  ~GreyPixels() {
    if (greys_ != nullptr) greys_->finish();
  }
  GreyPixels(const GreyPixels&) = delete;
  GreyPixels& operator=(const GreyPixels&) = delete;

  bool wanted() const { return share_ != nullptr || greys_ != nullptr; }
  /// The row of the file whose pixels come next.
  void next_row(std::uint32_t row) { row_ = row; }
  void add_white(unsigned pixels) {
    if (share_ != nullptr) share_->lit += pixels;
  }
  /// A pixel whose level is white at `full`.
  void add(std::uint32_t column, std::uint64_t level, std::uint64_t full) {
    if (level == 0) return;
    if (level >= full) return add_white(1);
    const auto share = static_cast<std::uint8_t>(level * kFullLevel / full);
    if (share_ != nullptr) {
      ++share_->lit;
      ++share_->grey;
      share_->lost += share < kLeastCuringLevel ? 1 : 0;
    }
    if (greys_ != nullptr && share > 0) greys_->add(placed_.pixel(column, row_), share);
  }

 private:
  Placed placed_;
  GreyShare* share_;
  GreyRuns* greys_;
  std::uint32_t row_ = 0;
};

/// The same of grey with opacity.
void threshold_grey_with_opacity(std::span<const unsigned char> line, std::uint32_t columns, std::size_t step,
                                 std::span<std::uint64_t> bits, GreyPixels& grey) {
  std::fill(bits.begin(), bits.end(), 0);
  for (std::uint32_t column = 0; column < columns; ++column) {
    const unsigned char* const at = &line[step * column];
    const bool shown = shows(at[0], at[step / 2]);
    bits[column / 64] |= std::uint64_t{shown ? 1U : 0U} << (column % 64);
    if (grey.wanted()) grey.add(column, std::uint64_t{at[0]} * at[step / 2], 255U * 255U);
  }
}

/// The same of colours: red, green, blue and opacity, 8 bits each.
void threshold_colours(std::span<const unsigned char> line, std::uint32_t columns, std::span<std::uint64_t> bits,
                       GreyPixels& grey) {
  std::fill(bits.begin(), bits.end(), 0);
  for (std::uint32_t column = 0; column < columns; ++column) {
    const unsigned char* const at = &line[std::size_t{4} * column];
    const unsigned luma = 299U * at[0] + 587U * at[1] + 114U * at[2];
    const bool shown = luma * at[3] >= 128'000U * 255U;
    bits[column / 64] |= std::uint64_t{shown ? 1U : 0U} << (column % 64);
    if (grey.wanted()) grey.add(column, std::uint64_t{luma} * at[3], 255'000U * 255U);
  }
}

/// Takes note of the pixels of a row without opacity. Few pixels of a mask are grey: eight at a time are looked at.
/// @param depth, step  as those of threshold()
void add_greys(std::span<const unsigned char> line, std::uint32_t columns, std::size_t depth, std::size_t step,
               GreyPixels& grey) {
  const unsigned white = depth < 8 ? (1U << depth) - 1 : 255;
  for (std::uint32_t column = 0; column < columns; ++column) {
    if (depth == 8 && columns - column >= 8) {
      std::uint64_t eight = 0;
      std::memcpy(&eight, &line[column], sizeof eight);
      const bool lit = ~eight == 0;
      if (eight == 0 || lit) {
        grey.add_white(lit ? 8 : 0);
        column += 7;
        continue;
      }
    }
    const std::size_t bit = std::size_t{column} * depth % 8;
    const unsigned level = depth < 8 ? (line[column * depth / 8] >> (8 - depth - bit)) & white : line[column * step];
    grey.add(column, level, white);
  }
}

/// Adds a row of the file where it lies on the plate.
void place(std::span<const std::uint64_t> bits, std::uint32_t row, const Placed& placed, BitImage out) {
  const MaskTurn& turn = placed.turn;
  const std::uint32_t across = placed.across(row);
  if (!turn.mirror_x && !turn.swaps) {
    const auto row_of_out = out.row(across);
    for (std::size_t w = 0; w < bits.size(); ++w) row_of_out[w] |= bits[w];
    return;
  }
  for (std::size_t w = 0; w < bits.size(); ++w) {
    for (std::uint64_t rest = bits[w]; rest != 0; rest &= rest - 1) {
      const auto column = static_cast<std::uint32_t>(64 * w) + static_cast<std::uint32_t>(std::countr_zero(rest));
      const std::uint32_t along = placed.along(column);
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

Status decode_turned_mask(PngBytes bytes, std::uint64_t most_bytes, const MaskTurn& turn, BitImage out, GreyShare* grey,
                          GreyRuns* greys) {
  const Placed placed(turn, out);
  const std::uint32_t columns = placed.columns, rows = placed.rows;
  GreyPixels pixels(placed, grey, greys);
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
    pixels.next_row(*row);
    if (header->is_grey && header->channels == 2) {
      threshold_grey_with_opacity({line.get(), line_bytes}, columns, header->depth / std::size_t{4},
                                  {bits.get(), words}, pixels);
    } else if (header->is_grey) {
      threshold({line.get(), line_bytes}, columns, header->depth, header->depth / std::size_t{8}, {bits.get(), words});
      if (pixels.wanted()) {
        add_greys({line.get(), line_bytes}, columns, header->depth, header->depth / std::size_t{8}, pixels);
      }
    } else {
      threshold_colours({line.get(), line_bytes}, columns, {bits.get(), words}, pixels);
    }
    place({bits.get(), words}, *row, placed, out);
  }
  return file.finish();
}

Status decode_mask(std::span<const std::byte> file, BitImage out) {
  BytesOf bytes{file};
  return decode_turned_mask(bytes, UINT64_MAX, {}, out);
}

}  // namespace plumbline::firmware::inline pictures
