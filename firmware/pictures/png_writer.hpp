#pragma once
/// PNG images: masks by mask_deflate, small pictures by libdeflate, others by lodepng with libdeflate behind it; masks read by lodepng,
/// small pictures by libdeflate.

#include <cstddef>
#include <cstdint>
#include <memory>
#include <span>
#include <vector>

#include "firmware/pictures/mask_deflate.hpp"
#include "slicer/core/bit_image.hpp"
#include "slicer/core/error.hpp"

struct libdeflate_compressor;
struct libdeflate_decompressor;

namespace plumbline {

/// Encodes one image after another, with buffers and a compressor that it takes once, when it is made.
///
/// For a picture, but not for a mask, lodepng takes memory with malloc: Debian builds the library with its own allocators, which
/// can't be replaced.
class PngEncoder {
 public:
  /// For masks of up to `columns` x `rows`.
  /// @retval ErrorCode::kOutOfMemory  the heap has no room for the buffers
  [[nodiscard]] static Expected<PngEncoder> for_masks(std::uint32_t columns, std::uint32_t rows,
                                                      MaskDepth depth = MaskDepth::kBit);
  /// For pictures of up to `columns` x `rows`, 8-bit RGB.
  /// @retval ErrorCode::kOutOfMemory  the heap has no room for the buffers
  [[nodiscard]] static Expected<PngEncoder> for_pictures(std::uint32_t columns, std::uint32_t rows, int level = 6);

  /// Greyscale, white where resin cures.
  /// @param mask  1 x 1 or more, not larger than the encoder was made for
  /// @returns the whole file, valid until the next call
  std::span<const std::byte> encode(ConstBitImage mask);

  /// 8-bit RGB.
  /// @param rgb  3 * columns * rows bytes, row after row from the top
  /// @returns the whole file, valid until the next call
  /// @retval ErrorCode::kOutOfMemory  lodepng found no memory
  [[nodiscard]] Expected<std::span<const std::byte>> encode(std::span<const std::uint8_t> rgb, std::uint32_t columns,
                                                            std::uint32_t rows);

 private:
  struct FreeCompressor {
    void operator()(libdeflate_compressor* compressor) const;
  };
  /// Its pages exist from when they are filled: a compressed picture is far smaller than its bound.
  struct Buffer {
    std::unique_ptr<unsigned char[]> bytes;
    std::size_t size = 0;

    [[nodiscard]] bool take(std::size_t count);
  };

  PngEncoder() = default;
  [[nodiscard]] Expected<std::span<const std::byte>> encode_raw(const unsigned char* raw, std::uint32_t columns,
                                                                std::uint32_t rows);
  static unsigned compress(unsigned char** out, std::size_t* out_size, const unsigned char* in, std::size_t in_size,
                           const void* settings);

  std::unique_ptr<libdeflate_compressor, FreeCompressor> compressor_;  ///< of pictures
  Buffer compressed_;                                                  ///< the zlib stream of a picture
  Buffer file_;                                                        ///< what encode() returns
  MaskDepth depth_ = MaskDepth::kBit;
};

/// Encodes small pictures without the heap: for a process whose memory is fixed. All memory is taken when it is made.
class SmallPngEncoder {
 public:
  /// @param most_bytes  of the pixels of any picture
  /// @retval ErrorCode::kOutOfMemory  the heap has no room for the buffers
  [[nodiscard]] static Expected<SmallPngEncoder> create(std::size_t most_bytes, std::uint32_t most_rows);

  /// @param pixels    channels * columns * rows bytes, row after row from the top
  /// @param channels  1: grey levels, 3: RGB
  /// @returns the whole file, valid until the next call
  std::span<const std::byte> encode(std::span<const std::uint8_t> pixels, std::uint32_t columns, std::uint32_t rows,
                                    std::uint32_t channels);

 private:
  struct FreeCompressor {
    void operator()(libdeflate_compressor* compressor) const;
  };
  SmallPngEncoder() = default;

  std::unique_ptr<libdeflate_compressor, FreeCompressor> compressor_;
  std::vector<std::uint8_t> lines_;  ///< filtered
  std::vector<std::uint8_t> file_;
};

struct PngSize {
  std::uint32_t columns = 0, rows = 0;  ///< 1 to PrintGrid::kMaxSide
};

/// Decodes what SmallPngEncoder has encoded, without the heap. All memory is taken when it is made. Any bytes are safe to decode.
class SmallPngDecoder {
 public:
  /// @param most_bytes  of the pixels of any picture
  /// @retval ErrorCode::kOutOfMemory  the heap has no room for the buffers
  [[nodiscard]] static Expected<SmallPngDecoder> create(std::size_t most_bytes, std::uint32_t most_rows);

  /// @param channels  1: grey levels, 3: RGB
  /// @param pixels    channels * columns * rows bytes of it are written, row after row from the top
  /// @retval ErrorCode::kMalformed    damaged, or none of SmallPngEncoder's with so many channels
  /// @retval ErrorCode::kUnsupported  larger than `most` or `pixels`
  [[nodiscard]] Expected<PngSize> decode(std::span<const std::byte> file, std::uint32_t channels, PngSize most,
                                         std::span<std::uint8_t> pixels);

 private:
  struct FreeDecompressor {
    void operator()(libdeflate_decompressor* decompressor) const;
  };
  SmallPngDecoder() = default;

  std::unique_ptr<libdeflate_decompressor, FreeDecompressor> decompressor_;
  std::vector<std::uint8_t> lines_;  ///< filtered
};

/// @param file  of a PNG
/// @retval ErrorCode::kMalformed    no PNG
/// @retval ErrorCode::kUnsupported  larger than a grid can be
[[nodiscard]] Expected<PngSize> png_size(std::span<const std::byte> file);

/// Decodes a PNG of any grey format; levels above 127 of 255 are white. Takes memory from the heap.
/// @param out  overwritten
/// @retval ErrorCode::kMalformed    no PNG, damaged, or not of the size of `out`
/// @retval ErrorCode::kUnsupported  it has colours
[[nodiscard]] Status decode_mask(std::span<const std::byte> file, BitImage out);

}  // namespace plumbline
