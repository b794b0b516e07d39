#include "firmware/pictures/png_writer.hpp"

#include <libdeflate.h>
#include <lodepng.h>

#include <algorithm>
#include <array>
#include <cassert>
#include <cstdlib>
#include <cstring>
#include <memory>
#include <new>

#include "firmware/pictures/mask_deflate.hpp"
#include "slicer/core/print_grid.hpp"

namespace plumbline {
namespace {

/// Bytes of a PNG file besides its compressed pixels: signature, header, frame of one data chunk, end chunk.
constexpr std::size_t kFrameBytes = 8 + 25 + 12 + 12;

constexpr std::array<std::uint8_t, 8> kSignature{0x89, 'P', 'N', 'G', '\r', '\n', 0x1A, '\n'};
/// Filter of a small picture's lines: each byte less the one above it.
constexpr std::uint8_t kUpFilter = 2;

/// libdeflate's level for small pictures: they are made while a printer has other things to do.
constexpr int kSmallLevel = 8;

struct PngFormat {
  std::uint32_t columns = 0, rows = 0;
  unsigned bits = 8;  ///< a channel
  LodePNGColorType colour = LCT_GREY;
};

/// Writes a PNG file round the zlib stream of its lines.
/// @param compress  writes the stream into a span, returns its size
/// @param file      kFrameBytes more than that needs
template <class Compress>
std::span<const std::byte> write_png(const PngFormat& format, const Compress& compress, std::span<std::uint8_t> file) {
  std::size_t size = 0;
  const auto put = [&](std::span<const std::uint8_t> bytes) {
    std::copy(bytes.begin(), bytes.end(), file.begin() + static_cast<std::ptrdiff_t>(size));
    size += bytes.size();
  };
  const auto put_number = [&](std::size_t value) {
    for (int shift = 24; shift >= 0; shift -= 8) file[size++] = static_cast<std::uint8_t>(value >> shift);
  };
  const auto end_chunk = [&](std::size_t begin) {
    put_number(libdeflate_crc32(0, file.data() + begin + 4, size - begin - 4));
  };
  put(kSignature);
  std::size_t begin = size;
  put_number(13);
  put(std::array<std::uint8_t, 4>{'I', 'H', 'D', 'R'});
  put_number(format.columns);
  put_number(format.rows);
  put(std::array<std::uint8_t, 5>{static_cast<std::uint8_t>(format.bits), static_cast<std::uint8_t>(format.colour), 0,
                                  0, 0});
  end_chunk(begin);
  begin = size;
  const std::size_t packed = compress(file.subspan(size + 8, file.size() - size - 8 - 4 - 12));
  put_number(packed);
  put(std::array<std::uint8_t, 4>{'I', 'D', 'A', 'T'});
  size += packed;
  end_chunk(begin);
  begin = size;
  put_number(0);
  put(std::array<std::uint8_t, 4>{'I', 'E', 'N', 'D'});
  end_chunk(begin);
  return std::as_bytes(std::span<const std::uint8_t>(file).first(size));
}

}  // namespace

void PngEncoder::FreeCompressor::operator()(libdeflate_compressor* compressor) const {
  libdeflate_free_compressor(compressor);
}

bool PngEncoder::Buffer::take(std::size_t count) {
  bytes.reset(new (std::nothrow) unsigned char[count]);
  size = count;
  return bytes != nullptr;
}

Expected<PngEncoder> PngEncoder::for_masks(std::uint32_t columns, std::uint32_t rows, MaskDepth depth) {
  PngEncoder encoder;
  encoder.depth_ = depth;
  if (!encoder.file_.take(deflated_mask_bound(columns, rows, depth) + kFrameBytes)) {
    return fail(ErrorCode::kOutOfMemory, "PNG encoder: no memory for a mask");
  }
  return encoder;
}

Expected<PngEncoder> PngEncoder::for_pictures(std::uint32_t columns, std::uint32_t rows, int level) {
  assert(columns > 0 && rows > 0 && level >= 1 && level <= 12);
  PngEncoder encoder;
  encoder.compressor_.reset(libdeflate_alloc_compressor(level));
  if (!encoder.compressor_) return fail(ErrorCode::kOutOfMemory, "PNG encoder: no memory for the compressor");
  const std::size_t lines = (1 + std::size_t{3} * columns) * rows;
  const std::size_t bound = libdeflate_zlib_compress_bound(encoder.compressor_.get(), lines);
  if (!encoder.compressed_.take(bound) || !encoder.file_.take(bound + kFrameBytes)) {
    return fail(ErrorCode::kOutOfMemory, "PNG encoder: no memory for a picture");
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
                                                            std::uint32_t rows) {
  LodePNGState state;
  lodepng_state_init(&state);
  state.info_raw.colortype = LCT_RGB;
  state.info_raw.bitdepth = 8;
  state.info_png.color.colortype = state.info_raw.colortype;
  state.info_png.color.bitdepth = state.info_raw.bitdepth;
  state.encoder.auto_convert = 0;
  state.encoder.filter_palette_zero = 1;
  state.encoder.filter_strategy = LFS_MINSUM;
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

std::span<const std::byte> PngEncoder::encode(ConstBitImage mask) {
  return write_png({mask.columns(), mask.rows(), static_cast<unsigned>(depth_), LCT_GREY},
                   [&](std::span<std::uint8_t> out) { return deflate_mask(mask, depth_, out); },
                   {file_.bytes.get(), file_.size});
}

Expected<std::span<const std::byte>> PngEncoder::encode(std::span<const std::uint8_t> rgb, std::uint32_t columns,
                                                        std::uint32_t rows) {
  assert(columns > 0 && rows > 0 && rgb.size() == std::size_t{3} * columns * rows);
  assert((1 + std::size_t{3} * columns) * rows <= compressed_.size);
  return encode_raw(rgb.data(), columns, rows);
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
  for (std::size_t r = 0; r < rows; ++r) {
    std::uint8_t* const line = lines_.data() + r * (width + 1);
    line[0] = kUpFilter;
    for (std::size_t i = 0; i < width; ++i) {
      const unsigned above = r > 0 ? pixels[(r - 1) * width + i] : 0U;
      line[1 + i] = static_cast<std::uint8_t>(pixels[r * width + i] - above);
    }
  }
  const auto compress = [this, lines = rows * (width + 1)](std::span<std::uint8_t> out) {
    return libdeflate_zlib_compress(compressor_.get(), lines_.data(), lines, out.data(), out.size());
  };
  return write_png({columns, rows, 8, channels == 3 ? LCT_RGB : LCT_GREY}, compress, file_);
}

void SmallPngDecoder::FreeDecompressor::operator()(libdeflate_decompressor* decompressor) const {
  libdeflate_free_decompressor(decompressor);
}

Expected<SmallPngDecoder> SmallPngDecoder::create(std::size_t most_bytes, std::uint32_t most_rows) {
  SmallPngDecoder decoder;
  decoder.decompressor_.reset(libdeflate_alloc_decompressor());
  if (!decoder.decompressor_) return fail(ErrorCode::kOutOfMemory, "PNG decoder: no memory for the decompressor");
  decoder.lines_.resize(most_bytes + most_rows);
  return decoder;
}

Expected<PngSize> SmallPngDecoder::decode(std::span<const std::byte> file, std::uint32_t channels, PngSize most,
                                          std::span<std::uint8_t> pixels) {
  const auto* const bytes = reinterpret_cast<const std::uint8_t*>(file.data());
  const auto number_at = [&](std::size_t at) {
    return std::uint32_t{bytes[at]} << 24U | std::uint32_t{bytes[at + 1]} << 16U | std::uint32_t{bytes[at + 2]} << 8U |
           bytes[at + 3];
  };
  const auto malformed = [] { return fail(ErrorCode::kMalformed, "the picture is damaged"); };
  // Where write_png() puts the header's fields, and the one chunk of data.
  constexpr std::size_t kHeader = 16, kDataSize = 33, kData = 41;
  if (file.size() < kFrameBytes || !std::equal(kSignature.begin(), kSignature.end(), bytes)) return malformed();
  const PngSize size{number_at(kHeader), number_at(kHeader + 4)};
  const std::size_t packed = number_at(kDataSize);
  if (bytes[kHeader + 8] != 8 || bytes[kHeader + 9] != (channels == 3 ? LCT_RGB : LCT_GREY) ||
      packed != file.size() - kFrameBytes || size.columns == 0 || size.rows == 0) {
    return malformed();
  }
  const std::size_t width = std::size_t{channels} * size.columns;
  if (size.columns > most.columns || size.rows > most.rows || width * size.rows > pixels.size() ||
      (width + 1) * size.rows > lines_.size()) {
    return fail(ErrorCode::kUnsupported, "the picture has %u x %u pixels", size.columns, size.rows);
  }
  const auto unpacked = libdeflate_zlib_decompress(decompressor_.get(), bytes + kData, packed, lines_.data(),
                                                   (width + 1) * size.rows, nullptr);
  if (unpacked != LIBDEFLATE_SUCCESS) return malformed();
  for (std::size_t r = 0; r < size.rows; ++r) {
    const std::uint8_t* const line = lines_.data() + r * (width + 1);
    if (line[0] != kUpFilter) return malformed();
    for (std::size_t i = 0; i < width; ++i) {
      const unsigned above = r > 0 ? pixels[(r - 1) * width + i] : 0U;
      pixels[r * width + i] = static_cast<std::uint8_t>(line[1 + i] + above);
    }
  }
  return size;
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
