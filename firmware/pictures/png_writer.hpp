#pragma once
/// PNG images: masks by mask_deflate, pictures by libdeflate; their sizes read by lodepng, small pictures by libdeflate.

#include <cstddef>
#include <cstdint>
#include <memory>
#include <span>
#include <utility>
#include <vector>

#include "firmware/pictures/mask_deflate.hpp"
#include "slicer/core/bit_image.hpp"
#include "slicer/core/error.hpp"

struct libdeflate_compressor;
struct libdeflate_decompressor;

namespace plumbline {

/// Its pages exist from when they are filled: a compressed picture is far smaller than its bound.
struct PngBuffer {
  std::unique_ptr<std::uint8_t[]> bytes;
  std::size_t size = 0;

  /// @returns false if the heap has no room
  [[nodiscard]] bool take(std::size_t count);
};

/// Encodes one mask after another, with a buffer that it takes once, when it is made.
class PngEncoder {
 public:
  /// For masks of up to `columns` x `rows`.
  /// @retval ErrorCode::kOutOfMemory  the heap has no room for the buffer
  [[nodiscard]] static Expected<PngEncoder> for_masks(std::uint32_t columns, std::uint32_t rows,
                                                      MaskDepth depth = MaskDepth::kBit);

  /// Greyscale, white where resin cures.
  /// @param mask  1 x 1 or more, not larger than the encoder was made for
  /// @returns the whole file, valid until the next call
  std::span<const std::byte> encode(ConstBitImage mask);

 private:
  PngEncoder() = default;

  PngBuffer file_;  ///< what encode() returns
  MaskDepth depth_ = MaskDepth::kBit;
};

/// Bytes of the lines of a picture's PNG: a filter and its pixels each.
constexpr std::size_t picture_memory(std::uint32_t columns, std::uint32_t rows, std::uint32_t channels = 3) {
  return (1 + std::size_t{channels} * columns) * rows;
}

/// Encodes one picture after another. Takes all memory when it is made.
class PictureEncoder {
 public:
  /// For pictures of up to `most_bytes`: picture_memory().
  /// @param level  of libdeflate
  /// @retval ErrorCode::kOutOfMemory  the heap has no room for the buffer and the compressor
  [[nodiscard]] static Expected<PictureEncoder> create(std::size_t most_bytes, int level = 5);

  /// @param memory    picture_memory(), overwritten: channels * columns * rows bytes are the pixels, row after row from the top
  /// @param channels  1: grey levels, 3: RGB
  /// @returns the whole file, valid until the next call
  std::span<const std::byte> encode(std::span<std::uint8_t> memory, std::uint32_t columns, std::uint32_t rows,
                                    std::uint32_t channels = 3);

 private:
  struct FreeCompressor {
    void operator()(libdeflate_compressor* compressor) const;
  };
  PictureEncoder() = default;

  std::unique_ptr<libdeflate_compressor, FreeCompressor> compressor_;
  PngBuffer file_;
};

/// Encodes small pictures that are kept: for a process whose memory is fixed. All memory is taken when it is made.
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
  explicit SmallPngEncoder(PictureEncoder encoder) : encoder_(std::move(encoder)) {}

  PictureEncoder encoder_;
  std::vector<std::uint8_t> lines_;
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

}  // namespace plumbline
