#pragma once
/// PNG images, by lodepng with libdeflate behind it.

#include <cstddef>
#include <cstdint>
#include <memory>
#include <span>

#include "slicer/core/bit_image.hpp"
#include "slicer/core/error.hpp"

struct libdeflate_compressor;

namespace plumbline {

/// Encodes images one after the other. Takes its buffers and its compressor once, when it is made.
class PngEncoder {
 public:
  static constexpr int kMaskLevel = 1;  ///< of libdeflate, 1 to 12

  /// For masks of up to `columns` x `rows`, 1 bit a pixel.
  /// @retval ErrorCode::kOutOfMemory  the heap has no room for the buffers
  [[nodiscard]] static Expected<PngEncoder> for_masks(std::uint32_t columns, std::uint32_t rows,
                                                      int level = kMaskLevel);
  /// For pictures of up to `columns` x `rows`, 8-bit RGB.
  /// @retval ErrorCode::kOutOfMemory  the heap has no room for the buffers
  [[nodiscard]] static Expected<PngEncoder> for_pictures(std::uint32_t columns, std::uint32_t rows, int level = 6);

  /// 1-bit greyscale, white (1) where the mask is set, that is: where resin cures.
  /// @param mask  1 x 1 or more, not larger than the encoder was made for
  /// @returns the whole file, valid until the next call
  /// @retval ErrorCode::kOutOfMemory  lodepng found no memory
  [[nodiscard]] Expected<std::span<const std::byte>> encode(ConstBitImage mask);

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
  struct Buffer {
    std::unique_ptr<unsigned char[]> bytes;
    std::size_t size = 0;
  };

  PngEncoder() = default;
  [[nodiscard]] static Expected<PngEncoder> create(std::size_t raw_bytes, std::uint32_t rows, int level);
  [[nodiscard]] Expected<std::span<const std::byte>> encode_raw(const unsigned char* raw, std::uint32_t columns,
                                                                std::uint32_t rows, bool is_mask);
  static unsigned compress(unsigned char** out, std::size_t* out_size, const unsigned char* in, std::size_t in_size,
                           const void* settings);

  std::unique_ptr<libdeflate_compressor, FreeCompressor> compressor_;
  Buffer packed_;      ///< the mask as PNG has it: first pixel in the high bit
  Buffer compressed_;  ///< the zlib stream
  Buffer file_;        ///< what encode() returns
};

}  // namespace plumbline
