#pragma once
/// PNG files, written and decoded row by row by libspng: in memory that depends on the width only, and that can be given to it.

#include <cstddef>
#include <cstdint>
#include <memory>
#include <optional>
#include <span>
#include <utility>
#include <vector>

#include "slicer/core/bit_image.hpp"
#include "slicer/core/error.hpp"
#include "slicer/core/function_ref.hpp"
#include "slicer/core/grey_runs.hpp"

struct spng_ctx;

namespace plumbline::firmware::inline pictures {

/// Hands out the next bytes of a PNG file. @returns as ByteSource::read()
using PngBytes = FunctionRef<Expected<std::size_t>(std::span<std::byte>)>;

struct PngHeader {
  std::uint32_t columns = 0, rows = 0;
  std::size_t depth = 0;     ///< bits of a channel
  std::size_t channels = 0;  ///< of a pixel as the file has it; 1 with a palette
  bool is_grey = false;      ///< with or without transparency
  bool is_interlaced = false;
};

/// Decodes a PNG of anybody's. The errors are those of libspng and of the bytes:
/// @retval ErrorCode::kMalformed    no PNG, damaged, cut off or too long
/// @retval ErrorCode::kOutOfMemory  the heap has no room for its rows: 200 kB for 8192 columns
class PngRows {
 public:
  enum class Form : bool {
    kAsStored,
    kRgba,  ///< 8 bits each of red, green, blue and opacity
  };

  /// @param bytes       must outlive it
  /// @param most_bytes  of the file; what is longer is refused when so many have come
  PngRows(PngBytes bytes, std::uint64_t most_bytes);
  ~PngRows();
  PngRows(const PngRows&) = delete;
  PngRows& operator=(const PngRows&) = delete;

  [[nodiscard]] Expected<PngHeader> header();
  /// @pre header() has succeeded
  [[nodiscard]] Status begin(Form form);
  /// Decodes the next row: from the top down, or in the order of an interlaced file's passes.
  /// @param line  the bytes of a whole row. Of an interlaced file, pixels that other passes have are left as they are
  /// @returns which row it is
  /// @pre rows_left() > 0
  [[nodiscard]] Expected<std::uint32_t> next(std::span<unsigned char> line);
  std::uint32_t rows_left() const { return rows_; }
  /// Reads on to the end of the file, so that its checksums are checked.
  [[nodiscard]] Status finish();

 private:
  struct Free {
    void operator()(spng_ctx* context) const;
  };
  static int read(spng_ctx* context, void* user, void* to, std::size_t length);
  [[nodiscard]] Status result(int reason) const;

  PngBytes bytes_;
  std::uint64_t left_;  ///< of the most that the file may have
  bool too_long_ = false;
  std::optional<Error> error_;  ///< of the bytes
  std::uint32_t rows_ = 0;      ///< that are still to come, of all passes
  std::unique_ptr<spng_ctx, Free> context_;
};

/// Its pages exist from when they are filled.
struct PngBuffer {
  std::unique_ptr<std::uint8_t[]> bytes;
  std::size_t size = 0;

  /// @returns false if the heap has no room
  [[nodiscard]] bool take(std::size_t count);
};

/// Writes one file after another. All memory is taken once.
class PngWriter {
 public:
  struct Format {
    std::uint32_t columns = 0, rows = 0;
    std::uint8_t depth = 8, channels = 1;  ///< channels 1: grey levels, 3: RGB
    bool is_mask = false;                  ///< compressed as runs, as fast as possible
  };
  /// @param most_bytes  of the rows of a file
  /// @retval ErrorCode::kOutOfMemory
  [[nodiscard]] static Expected<PngWriter> create(std::size_t most_bytes);
  /// @param row  hands out the bytes of a row
  /// @returns the whole file, valid until the next call
  std::span<const std::byte> write(const Format& format, FunctionRef<std::span<const std::uint8_t>(std::uint32_t)> row);

 private:
  PngWriter() = default;
  PngBuffer file_, memory_;  ///< the second is libspng's
};

/// How a PNG holds the pixels of a mask.
enum class MaskDepth : std::uint8_t {
  kBit,     ///< as bits; grey pixels as their bits
  kNeeded,  ///< as bits, those of a mask with grey pixels as bytes
  kByte,    ///< as bytes, 255 is white: the only ones that PrusaSlicer's reader of archives takes
};

/// Encodes one mask after another.
class PngEncoder {
 public:
  /// For masks of up to `columns` x `rows`. Takes all its memory here.
  /// @retval ErrorCode::kOutOfMemory
  [[nodiscard]] static Expected<PngEncoder> for_masks(std::uint32_t columns, std::uint32_t rows,
                                                      MaskDepth depth = MaskDepth::kBit);

  /// Greyscale, white where resin cures.
  /// @param mask   1 x 1 or more, not larger than the encoder was made for. Bits past the last column are ignored
  /// @param greys  of the mask, ascending
  /// @returns the whole file, valid until the next call
  std::span<const std::byte> encode(ConstBitImage mask, std::span<const GreyRun> greys = {});

 private:
  PngEncoder(PngWriter writer, std::uint32_t columns, MaskDepth depth);

  PngWriter writer_;
  MaskDepth depth_;
  std::vector<std::uint8_t> row_;
};

/// Bytes of a picture's pixels.
constexpr std::size_t picture_bytes(std::uint32_t columns, std::uint32_t rows, std::uint32_t channels = 3) {
  return std::size_t{channels} * columns * rows;
}

/// Encodes one picture after another.
class PictureEncoder {
 public:
  /// For pictures of up to `most_bytes`: picture_bytes(). Takes all its memory here.
  /// @retval ErrorCode::kOutOfMemory
  [[nodiscard]] static Expected<PictureEncoder> create(std::size_t most_bytes);

  /// @param pixels    picture_bytes(), row after row from the top
  /// @param channels  1: grey levels, 3: RGB
  /// @returns the whole file, valid until the next call
  std::span<const std::byte> encode(std::span<const std::uint8_t> pixels, std::uint32_t columns, std::uint32_t rows,
                                    std::uint32_t channels = 3);

 private:
  explicit PictureEncoder(PngWriter writer) : writer_(std::move(writer)) {}

  PngWriter writer_;
};

struct PngSize {
  std::uint32_t columns = 0, rows = 0;  ///< 1 to PrintGrid::kMaxSide
};

/// Decodes what PictureEncoder has encoded, without the heap. Any bytes are safe to decode.
class PictureDecoder {
 public:
  /// Takes all its memory here.
  /// @retval ErrorCode::kOutOfMemory
  [[nodiscard]] static Expected<PictureDecoder> create();

  /// @param channels  1: grey levels, 3: RGB
  /// @param pixels    picture_bytes() of it are written
  /// @retval ErrorCode::kMalformed    damaged, or none of PictureEncoder's with so many channels
  /// @retval ErrorCode::kUnsupported  larger than `most` or `pixels`
  [[nodiscard]] Expected<PngSize> decode(std::span<const std::byte> file, std::uint32_t channels, PngSize most,
                                         std::span<std::uint8_t> pixels);

 private:
  PictureDecoder() = default;

  PngBuffer memory_;
};

/// @param file  its first 33 bytes or more
/// @retval ErrorCode::kMalformed    no PNG
/// @retval ErrorCode::kUnsupported  larger than a grid can be
[[nodiscard]] Expected<PngSize> png_size(std::span<const std::byte> file);

/// Hands out the bytes of a file in memory.
struct BytesOf {
  std::span<const std::byte> file;
  Expected<std::size_t> operator()(std::span<std::byte> to);
};

}  // namespace plumbline::firmware::inline pictures
