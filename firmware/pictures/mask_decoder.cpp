#include "firmware/pictures/mask_decoder.hpp"

#include <spng.h>

#include <algorithm>
#include <bit>
#include <memory>
#include <new>
#include <optional>

namespace plumbline {
namespace {

struct FreeContext {
  void operator()(spng_ctx* context) const { spng_ctx_free(context); }
};

/// What libspng reads through.
struct Input {
  PngBytes& bytes;
  std::uint64_t left = 0;  ///< of the most that a file may have
  bool too_long = false;
  std::optional<Error> error;
};

int read_some(spng_ctx* /*context*/, void* user, void* to, std::size_t length) {
  Input& input = *static_cast<Input*>(user);
  if (length > input.left) {
    input.too_long = true;
    return SPNG_IO_ERROR;
  }
  input.left -= length;
  std::span<std::byte> rest(static_cast<std::byte*>(to), length);
  while (!rest.empty()) {
    const auto got = input.bytes(rest);
    if (!got) {
      input.error = got.error();
      return SPNG_IO_ERROR;
    }
    if (*got == 0) return SPNG_IO_EOF;
    rest = rest.subspan(*got);
  }
  return 0;
}

tl::unexpected<Error> refuse(const Input& input, int reason) {
  if (input.error) return tl::unexpected<Error>(*input.error);
  if (input.too_long) return fail(ErrorCode::kMalformed, "is longer than a mask can be.\tExport the layers again");
  if (reason == SPNG_EMEM) return fail(ErrorCode::kOutOfMemory, "no memory for its rows");
  return fail(ErrorCode::kMalformed, "cannot be read as PNG (%s).\tExport the layers again", spng_strerror(reason));
}

/// The highest bit of the first channel of each pixel: the upper half of its levels.
/// @param line  as the file has it, `step` bytes a pixel or `depth` bits
/// @param bits  one word for each 64 pixels
void threshold(std::span<const unsigned char> line, std::uint32_t columns, unsigned depth, std::size_t step,
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

/// Puts a row of the file where it lies on the plate.
void place(std::span<const std::uint64_t> bits, std::uint32_t row, const MaskTurn& turn, BitImage out) {
  const std::uint32_t columns = turn.swaps ? out.rows() : out.columns();
  const std::uint32_t rows = turn.swaps ? out.columns() : out.rows();
  const std::uint32_t across = turn.mirror_y ? rows - 1 - row : row;
  if (!turn.mirror_x && !turn.swaps) {
    std::copy(bits.begin(), bits.end(), out.row(across).begin());
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
  const std::uint64_t raw = (std::uint64_t{4} * columns + 1) * rows;
  return raw + raw / 64 + kRest;
}

Status decode_turned_mask(PngBytes bytes, std::uint64_t most_bytes, const MaskTurn& turn, BitImage out) {
  const std::uint32_t columns = turn.swaps ? out.rows() : out.columns();
  const std::uint32_t rows = turn.swaps ? out.columns() : out.rows();
  out.clear();
  const std::unique_ptr<spng_ctx, FreeContext> context(spng_ctx_new(0));
  Input input{bytes, most_bytes, false, std::nullopt};
  if (!context) return refuse(input, SPNG_EMEM);
  constexpr std::size_t kLargestChunk = 65536;  // that is kept: a palette, a text
  spng_set_chunk_limits(context.get(), kLargestChunk, kLargestChunk);
  spng_ihdr header = {};
  int reason = spng_set_png_stream(context.get(), read_some, &input);
  if (reason == 0) reason = spng_get_ihdr(context.get(), &header);
  if (reason != 0) return refuse(input, reason);
  if (header.width != columns || header.height != rows) {
    return fail(ErrorCode::kMalformed, "has %u x %u pixels, the first layer %u x %u.\tExport the layers again",
                header.width, header.height, columns, rows);
  }
  if (header.color_type != SPNG_COLOR_TYPE_GRAYSCALE && header.color_type != SPNG_COLOR_TYPE_GRAYSCALE_ALPHA) {
    return fail(ErrorCode::kUnsupported, "has colours; layers are black and white or grey.\tExport them as grey PNG");
  }
  if (header.interlace_method != SPNG_INTERLACE_NONE) {
    return fail(ErrorCode::kUnsupported, "is interlaced.\tExport the layers without interlacing");
  }
  const std::size_t channels = header.color_type == SPNG_COLOR_TYPE_GRAYSCALE ? 1 : 2;
  const std::size_t line_bytes = (channels * header.bit_depth * columns + 7) / 8;
  const std::unique_ptr<unsigned char[]> line(new (std::nothrow) unsigned char[line_bytes]);
  const std::size_t words = (columns + std::size_t{63}) / 64;
  const std::unique_ptr<std::uint64_t[]> bits(new (std::nothrow) std::uint64_t[words]);
  if (!line || !bits) return refuse(input, SPNG_EMEM);
  reason = spng_decode_image(context.get(), nullptr, 0, SPNG_FMT_RAW, SPNG_DECODE_PROGRESSIVE);
  for (std::uint32_t row = 0; row < rows && reason == 0; ++row) {
    reason = spng_decode_row(context.get(), line.get(), line_bytes);
    const bool last = row + 1 == rows;
    if (reason != 0 && !(last && reason == SPNG_EOI)) break;
    reason = 0;
    threshold({line.get(), line_bytes}, columns, header.bit_depth, channels * header.bit_depth / 8,
              {bits.get(), words});
    place({bits.get(), words}, row, turn, out);
  }
  // Reads on to the end of the file, so that its checksums are checked.
  if (reason == 0) reason = spng_decode_chunks(context.get());
  return reason == 0 ? Status() : Status(refuse(input, reason));
}

}  // namespace plumbline
