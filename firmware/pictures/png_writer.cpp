#include "firmware/pictures/png_writer.hpp"

#include <libdeflate.h>
#include <lodepng.h>

#include <algorithm>
#include <array>
#include <cassert>
#include <cstdlib>
#include <memory>
#include <new>

#include "firmware/pictures/mask_deflate.hpp"
#include "slicer/core/print_grid.hpp"

namespace plumbline {
namespace {

/// Bytes of a PNG file besides its compressed pixels: signature, header, frame of one data chunk, end chunk.
constexpr std::size_t kFrameBytes = 8 + 25 + 12 + 12;

constexpr std::array<std::uint8_t, 8> kSignature{0x89, 'P', 'N', 'G', '\r', '\n', 0x1A, '\n'};
/// Filter of a picture's lines: each byte less the one above it. Shaded surfaces come out no larger than with the best of five for each line.
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

bool PngBuffer::take(std::size_t count) {
  bytes.reset(new (std::nothrow) std::uint8_t[count]);
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

std::span<const std::byte> PngEncoder::encode(ConstBitImage mask) {
  return write_png({mask.columns(), mask.rows(), static_cast<unsigned>(depth_), LCT_GREY},
                   [&](std::span<std::uint8_t> out) { return deflate_mask(mask, depth_, out); },
                   {file_.bytes.get(), file_.size});
}

void PictureEncoder::FreeCompressor::operator()(libdeflate_compressor* compressor) const {
  libdeflate_free_compressor(compressor);
}

Expected<PictureEncoder> PictureEncoder::create(std::size_t most_bytes, int level) {
  PictureEncoder encoder;
  encoder.compressor_.reset(libdeflate_alloc_compressor(level));
  if (!encoder.compressor_) return fail(ErrorCode::kOutOfMemory, "PNG encoder: no memory for the compressor");
  const std::size_t bound = libdeflate_zlib_compress_bound(encoder.compressor_.get(), most_bytes);
  if (!encoder.file_.take(bound + kFrameBytes)) {
    return fail(ErrorCode::kOutOfMemory, "PNG encoder: no memory for a picture");
  }
  return encoder;
}

std::span<const std::byte> PictureEncoder::encode(std::span<std::uint8_t> memory, std::uint32_t columns,
                                                  std::uint32_t rows, std::uint32_t channels) {
  const std::size_t width = std::size_t{channels} * columns, size = picture_memory(columns, rows, channels);
  assert(memory.size() >= size && size + kFrameBytes <= file_.size);
  // A line lies after all rows that are still to be filtered: from the last one up, each takes the place of rows that are not needed.
  for (std::size_t r = rows; r-- > 0;) {
    std::uint8_t* const line = memory.data() + r * (width + 1);
    const std::uint8_t* const row = memory.data() + r * width;
    if (r > 0) {
      for (std::size_t i = width; i-- > 0;) line[1 + i] = static_cast<std::uint8_t>(row[i] - row[i - width]);
    } else {
      std::copy_backward(row, row + width, line + 1 + width);
    }
    line[0] = kUpFilter;
  }
  const auto compress = [&](std::span<std::uint8_t> out) {
    return libdeflate_zlib_compress(compressor_.get(), memory.data(), size, out.data(), out.size());
  };
  return write_png({columns, rows, 8, channels == 3 ? LCT_RGB : LCT_GREY}, compress, {file_.bytes.get(), file_.size});
}

Expected<SmallPngEncoder> SmallPngEncoder::create(std::size_t most_bytes, std::uint32_t most_rows) {
  auto encoder = PictureEncoder::create(most_bytes + most_rows, kSmallLevel);
  PLUMBLINE_TRY(encoder);
  SmallPngEncoder small(std::move(*encoder));
  small.lines_.resize(most_bytes + most_rows);
  return small;
}

std::span<const std::byte> SmallPngEncoder::encode(std::span<const std::uint8_t> pixels, std::uint32_t columns,
                                                   std::uint32_t rows, std::uint32_t channels) {
  assert(pixels.size() + rows <= lines_.size());
  std::copy(pixels.begin(), pixels.end(), lines_.begin());
  return encoder_.encode(lines_, columns, rows, channels);
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

}  // namespace plumbline
