#include "firmware/pictures/png_writer.hpp"

#include <libdeflate.h>
#include <lodepng.h>

#include <algorithm>
#include <array>
#include <bit>
#include <cassert>
#include <cstdlib>
#include <cstring>
#include <memory>
#include <new>

#include "slicer/core/print_grid.hpp"

namespace plumbline {
namespace {

/// Bytes of a PNG file besides its compressed pixels: signature, header, frame of one data chunk, end chunk.
constexpr std::size_t kFrameBytes = 8 + 25 + 12 + 12;

/// libdeflate's level for small pictures: they are made while a printer has other things to do.
constexpr int kSmallLevel = 8;

void store_big_endian(unsigned char* to, std::uint64_t word) {
  if constexpr (std::endian::native == std::endian::little) word = __builtin_bswap64(word);
  std::memcpy(to, &word, sizeof word);
}

/// Packs the pixels as lodepng takes them: first pixel in the high bit, rows not padded.
/// @param to  8 bytes more than the pixels fill
void pack(ConstBitImage mask, unsigned char* to) {
  std::uint64_t waiting = 0;  // bits that don't fill a word yet, from the high end
  unsigned filled = 0;
  const auto put = [&](std::uint64_t bits, unsigned count) {
    waiting |= bits >> filled;
    if (filled + count >= 64) {
      store_big_endian(to, waiting);
      to += 8;
      waiting = filled == 0 ? 0 : bits << (64 - filled);
    }
    filled = (filled + count) % 64;
  };
  for (std::uint32_t r = 0; r < mask.rows(); ++r) {
    const auto row = mask.row(r);
    for (std::uint32_t w = 0; w + 1 < mask.stride(); ++w) put(reversed_bits(row[w]), 64);
    put(reversed_bits(row.back() & mask.last_word_mask()), mask.columns() - 64 * (mask.stride() - 1));
  }
  store_big_endian(to, waiting);
}

}  // namespace

void PngEncoder::FreeCompressor::operator()(libdeflate_compressor* compressor) const {
  libdeflate_free_compressor(compressor);
}

Expected<PngEncoder> PngEncoder::for_masks(std::uint32_t columns, std::uint32_t rows, int level) {
  auto encoder = create((columns + std::size_t{7}) / 8, rows, level);
  PLUMBLINE_TRY(encoder);
  const std::size_t packed = (std::size_t{columns} * rows + 7) / 8 + 8;
  encoder->packed_.bytes.reset(new (std::nothrow) unsigned char[packed]());
  encoder->packed_.size = packed;
  if (!encoder->packed_.bytes) return fail(ErrorCode::kOutOfMemory, "PNG encoder: no memory for a mask");
  return encoder;
}

Expected<PngEncoder> PngEncoder::for_pictures(std::uint32_t columns, std::uint32_t rows, int level) {
  return create(std::size_t{3} * columns, rows, level);
}

Expected<PngEncoder> PngEncoder::create(std::size_t row_bytes, std::uint32_t rows, int level) {
  assert(row_bytes > 0 && rows > 0 && level >= 1 && level <= 12);
  PngEncoder encoder;
  encoder.compressor_.reset(libdeflate_alloc_compressor(level));
  if (!encoder.compressor_) return fail(ErrorCode::kOutOfMemory, "PNG encoder: no memory for the compressor");
  const std::size_t scan_lines = (1 + row_bytes) * rows;
  const std::size_t bound = libdeflate_zlib_compress_bound(encoder.compressor_.get(), scan_lines);
  // Zeroed, so that their pages exist before the first layer needs them.
  encoder.compressed_ = {std::unique_ptr<unsigned char[]>(new (std::nothrow) unsigned char[bound]()), bound};
  encoder.file_ = {std::unique_ptr<unsigned char[]>(new (std::nothrow) unsigned char[bound + kFrameBytes]()),
                   bound + kFrameBytes};
  if (!encoder.compressed_.bytes || !encoder.file_.bytes) {
    return fail(ErrorCode::kOutOfMemory, "PNG encoder: no memory for %zu bytes of output", bound);
  }
  return encoder;
}

/// lodepng's hook for the zlib stream. `out` is freed by lodepng with free().
unsigned PngEncoder::compress(unsigned char** out, std::size_t* out_size, const unsigned char* in, std::size_t in_size,
                              const void* settings) {
  constexpr unsigned kNoMemory = 83;  // lodepng's number
  const auto* self =
      static_cast<const PngEncoder*>(static_cast<const LodePNGCompressSettings*>(settings)->custom_context);
  const std::size_t size = libdeflate_zlib_compress(self->compressor_.get(), in, in_size, self->compressed_.bytes.get(),
                                                    self->compressed_.size);
  if (size == 0) return kNoMemory;
  // lodepng keeps this block, so it is as large as the result, not as the bound.
  *out = static_cast<unsigned char*>(std::malloc(size));
  if (*out == nullptr) return kNoMemory;
  std::memcpy(*out, self->compressed_.bytes.get(), size);
  *out_size = size;
  return 0;
}

Expected<std::span<const std::byte>> PngEncoder::encode_raw(const unsigned char* raw, std::uint32_t columns,
                                                            std::uint32_t rows, bool is_mask) {
  LodePNGState state;
  lodepng_state_init(&state);
  state.info_raw.colortype = is_mask ? LCT_GREY : LCT_RGB;
  state.info_raw.bitdepth = is_mask ? 1 : 8;
  state.info_png.color.colortype = state.info_raw.colortype;
  state.info_png.color.bitdepth = state.info_raw.bitdepth;
  state.encoder.auto_convert = 0;
  state.encoder.filter_palette_zero = 1;
  state.encoder.filter_strategy = is_mask ? LFS_ZERO : LFS_MINSUM;
  state.encoder.zlibsettings.custom_zlib = [](unsigned char** out, std::size_t* out_size, const unsigned char* in,
                                              std::size_t in_size, const LodePNGCompressSettings* settings) {
    return compress(out, out_size, in, in_size, settings);
  };
  state.encoder.zlibsettings.custom_context = this;
  unsigned char* out = nullptr;
  std::size_t size = 0;
  const unsigned error = lodepng_encode(&out, &size, raw, columns, rows, &state);
  lodepng_state_cleanup(&state);
  if (error == 0) {
    assert(size <= file_.size);
    std::memcpy(file_.bytes.get(), out, size);
  }
  std::free(out);
  if (error != 0) return fail(ErrorCode::kOutOfMemory, "PNG encoder: %s", lodepng_error_text(error));
  return std::as_bytes(std::span<const unsigned char>(file_.bytes.get(), size));
}

Expected<std::span<const std::byte>> PngEncoder::encode(ConstBitImage mask) {
  assert(mask.columns() > 0 && mask.rows() > 0);
  assert((std::size_t{mask.columns()} * mask.rows() + 7) / 8 + 8 <= packed_.size);
  pack(mask, packed_.bytes.get());
  return encode_raw(packed_.bytes.get(), mask.columns(), mask.rows(), true);
}

Expected<std::span<const std::byte>> PngEncoder::encode(std::span<const std::uint8_t> rgb, std::uint32_t columns,
                                                        std::uint32_t rows) {
  assert(columns > 0 && rows > 0 && rgb.size() == std::size_t{3} * columns * rows);
  assert((1 + std::size_t{3} * columns) * rows <= compressed_.size);
  return encode_raw(rgb.data(), columns, rows, false);
}

void SmallPngEncoder::FreeCompressor::operator()(libdeflate_compressor* compressor) const {
  libdeflate_free_compressor(compressor);
}

Expected<SmallPngEncoder> SmallPngEncoder::create(std::size_t most_bytes, std::uint32_t most_rows) {
  SmallPngEncoder encoder;
  encoder.compressor_.reset(libdeflate_alloc_compressor(kSmallLevel));
  if (!encoder.compressor_) return fail(ErrorCode::kOutOfMemory, "PNG encoder: no memory for the compressor");
  encoder.lines_.resize(most_bytes + most_rows);
  encoder.file_.resize(libdeflate_zlib_compress_bound(encoder.compressor_.get(), encoder.lines_.size()) + kFrameBytes);
  return encoder;
}

std::span<const std::byte> SmallPngEncoder::encode(std::span<const std::uint8_t> pixels, std::uint32_t columns,
                                                   std::uint32_t rows, std::uint32_t channels) {
  const std::size_t width = std::size_t{channels} * columns;
  assert(pixels.size() == width * rows && pixels.size() + rows <= lines_.size());
  // Each byte less the one above it: filter 2 of PNG.
  for (std::size_t r = 0; r < rows; ++r) {
    std::uint8_t* const line = lines_.data() + r * (width + 1);
    line[0] = 2;
    for (std::size_t i = 0; i < width; ++i) {
      const unsigned above = r > 0 ? pixels[(r - 1) * width + i] : 0U;
      line[1 + i] = static_cast<std::uint8_t>(pixels[r * width + i] - above);
    }
  }
  std::size_t size = 0;
  const auto put = [&](std::span<const std::uint8_t> bytes) {
    std::copy(bytes.begin(), bytes.end(), file_.begin() + static_cast<std::ptrdiff_t>(size));
    size += bytes.size();
  };
  const auto put_number = [&](std::size_t value) {
    for (int shift = 24; shift >= 0; shift -= 8) file_[size++] = static_cast<std::uint8_t>(value >> shift);
  };
  const auto end_chunk = [&](std::size_t begin) {
    put_number(libdeflate_crc32(0, file_.data() + begin + 4, size - begin - 4));
  };
  put(std::array<std::uint8_t, 8>{0x89, 'P', 'N', 'G', '\r', '\n', 0x1A, '\n'});
  std::size_t begin = size;
  put_number(13);
  put(std::array<std::uint8_t, 4>{'I', 'H', 'D', 'R'});
  put_number(columns);
  put_number(rows);
  put(std::array<std::uint8_t, 5>{8, static_cast<std::uint8_t>(channels == 3 ? LCT_RGB : LCT_GREY), 0, 0, 0});
  end_chunk(begin);
  begin = size;
  const std::size_t room = file_.size() - size - 8 - 4 - 12;
  const std::size_t packed =
      libdeflate_zlib_compress(compressor_.get(), lines_.data(), rows * (width + 1), file_.data() + size + 8, room);
  put_number(packed);
  put(std::array<std::uint8_t, 4>{'I', 'D', 'A', 'T'});
  size += packed;
  end_chunk(begin);
  begin = size;
  put_number(0);
  put(std::array<std::uint8_t, 4>{'I', 'E', 'N', 'D'});
  end_chunk(begin);
  return std::as_bytes(std::span<const std::uint8_t>(file_).first(size));
}

Expected<PngSize> png_size(std::span<const std::byte> file) {
  unsigned columns = 0;
  unsigned rows = 0;
  LodePNGState state;
  lodepng_state_init(&state);
  const unsigned error =
      lodepng_inspect(&columns, &rows, &state, reinterpret_cast<const unsigned char*>(file.data()), file.size());
  lodepng_state_cleanup(&state);
  if (error != 0) {
    return fail(ErrorCode::kMalformed, "cannot be read as PNG (%s).\tExport the layers again",
                lodepng_error_text(error));
  }
  if (columns > PrintGrid::kMaxSide || rows > PrintGrid::kMaxSide) {
    return fail(ErrorCode::kUnsupported, "has %u x %u pixels, at most %u x %u are allowed", columns, rows,
                PrintGrid::kMaxSide, PrintGrid::kMaxSide);
  }
  return PngSize{columns, rows};
}

Status decode_mask(std::span<const std::byte> file, BitImage out) {
  const auto size = png_size(file);
  PLUMBLINE_TRY(size);
  if (size->columns != out.columns() || size->rows != out.rows()) {
    return fail(ErrorCode::kMalformed,
                "has %u x %u pixels, the first layer %u x %u.\tName a folder that holds one stack", size->columns,
                size->rows, out.columns(), out.rows());
  }
  // lodepng would take the red of coloured pixels. The colour type of a PNG is byte 25: 2 and 6 have colours.
  const auto colour = static_cast<unsigned>(file[25]);
  if (colour == LCT_RGB || colour == LCT_RGBA) {
    return fail(ErrorCode::kUnsupported, "has colours; layers are black and white or grey.\tExport them as grey PNG");
  }
  unsigned char* grey = nullptr;
  unsigned columns = 0;
  unsigned rows = 0;
  const unsigned error = lodepng_decode_memory(
      &grey, &columns, &rows, reinterpret_cast<const unsigned char*>(file.data()), file.size(), LCT_GREY, 8);
  const std::unique_ptr<unsigned char, decltype(&std::free)> pixels(grey, &std::free);
  if (error != 0) {
    return fail(ErrorCode::kMalformed, "cannot be read as PNG (%s).\tExport the layers again",
                lodepng_error_text(error));
  }
  out.clear();
  for (std::uint32_t r = 0; r < out.rows(); ++r) {
    const unsigned char* const line = grey + std::size_t{r} * out.columns();
    for (std::uint32_t c = 0; c < out.columns(); ++c) {
      if (line[c] > 127) out.set(c, r);
    }
  }
  return {};
}

}  // namespace plumbline
