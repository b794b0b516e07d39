#pragma once
/// Decodes a PNG of anybody's row by row, in memory that depends on its width only. By libspng: lodepng needs room for the whole file and
/// for all pixels, from a heap that can't be replaced.

#include <cstddef>
#include <cstdint>
#include <memory>
#include <optional>
#include <span>

#include "slicer/core/error.hpp"
#include "slicer/core/function_ref.hpp"

struct spng_ctx;

namespace plumbline {

/// Hands out the next bytes of a PNG file. @returns as ByteSource::read()
using PngBytes = FunctionRef<Expected<std::size_t>(std::span<std::byte>)>;

struct PngHeader {
  std::uint32_t columns = 0, rows = 0;
  std::size_t depth = 0;     ///< bits of a channel
  std::size_t channels = 0;  ///< of a pixel as the file has it; 1 with a palette
  bool is_grey = false;      ///< with or without transparency
  bool is_interlaced = false;
};

/// The errors are those of libspng and of the bytes:
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
  /// Decodes the next row: from the top, or as the passes of an interlaced file come.
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

}  // namespace plumbline
