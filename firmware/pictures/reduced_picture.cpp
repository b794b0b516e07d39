#include "firmware/pictures/reduced_picture.hpp"

#include <algorithm>
#include <cmath>
#include <cstddef>
#include <memory>
#include <new>

#include "firmware/pictures/preview/picture.hpp"

namespace plumbline::firmware::inline pictures {
namespace {

constexpr std::uint64_t kMostBytes = 16'000'000;  // of the file
constexpr std::size_t kChannels = 4;

/// The pixels of the file that fall on one of the picture's.
struct Sum {
  std::uint64_t red = 0, green = 0, blue = 0;  ///< each times its opacity
  std::uint64_t opacity = 0;                   ///< 0 to 255 each
  std::uint64_t count = 0;

  void add(const unsigned char* pixel) {
    const std::uint64_t opaque = pixel[3];
    red += pixel[0] * opaque;
    green += pixel[1] * opaque;
    blue += pixel[2] * opaque;
    opacity += opaque;
    ++count;
  }
  Rgb colour() const {
    const auto mean = [this](std::uint64_t sum) { return static_cast<std::uint8_t>(sum / opacity); };
    return {mean(red), mean(green), mean(blue)};
  }
  float cover() const { return static_cast<float>(opacity) / (255 * static_cast<float>(count)); }
};

std::uint32_t reduced(std::uint32_t side, double scale) {
  return std::max(1U, static_cast<std::uint32_t>(std::lround(side * scale)));
}

}  // namespace

Status decode_reduced(PngBytes bytes, std::span<std::uint8_t> rgb, const PngSize& size) {
  const Picture out{rgb, size.columns, size.rows};
  PngRows file(bytes, kMostBytes);
  const auto header = file.header();
  PLUMBLINE_TRY(header);
  const std::uint32_t columns = header->columns, rows = header->rows;
  if (columns > kMostPictureSide || rows > kMostPictureSide) {
    return fail(ErrorCode::kUnsupported, "has %u x %u pixels, a picture may have %u x %u", columns, rows,
                kMostPictureSide, kMostPictureSide);
  }
  if (header->is_interlaced) return fail(ErrorCode::kUnsupported, "is interlaced");
  const double scale = std::min({1.0, double{1} * out.columns / columns, double{1} * out.rows / rows});
  const std::uint32_t wide = std::min(reduced(columns, scale), out.columns);
  const std::uint32_t high = std::min(reduced(rows, scale), out.rows);
  const std::uint32_t left = (out.columns - wide) / 2, top = (out.rows - high) / 2;
  const std::size_t line_bytes = kChannels * columns;
  const std::unique_ptr<unsigned char[]> line(new (std::nothrow) unsigned char[line_bytes]);
  const std::unique_ptr<Sum[]> sums(new (std::nothrow) Sum[wide]);
  if (!line || !sums) return fail(ErrorCode::kOutOfMemory, "no memory for its rows");
  PLUMBLINE_TRY(file.begin(PngRows::Form::kRgba));
  for (std::uint32_t row = 0; row < rows; ++row) {
    PLUMBLINE_TRY(file.next({line.get(), line_bytes}));
    for (std::uint32_t c = 0; c < columns; ++c) sums[std::size_t{c} * wide / columns].add(&line[kChannels * c]);
    const auto y = static_cast<std::uint32_t>(std::uint64_t{row} * high / rows);
    if (row + 1 < rows && (std::uint64_t{row} + 1) * high / rows == y) continue;
    for (std::uint32_t x = 0; x < wide; ++x) {
      if (sums[x].opacity > 0) out.blend(left + x, top + y, sums[x].colour(), sums[x].cover());
      sums[x] = {};
    }
  }
  return file.finish();
}

}  // namespace plumbline::firmware::inline pictures
