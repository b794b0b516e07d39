#include "firmware/pictures/png_rows.hpp"

#include <spng.h>

namespace plumbline {
namespace {

/// Rows of the seven passes of an interlaced file (PNG specification, 8.2).
std::uint32_t interlaced_rows(std::uint32_t columns, std::uint32_t rows) {
  struct Pass {
    std::uint32_t column, row, row_step;
  };
  constexpr Pass kPasses[] = {{0, 0, 8}, {4, 0, 8}, {0, 4, 8}, {2, 0, 4}, {0, 2, 4}, {1, 0, 2}, {0, 1, 2}};
  std::uint32_t all = 0;
  for (const Pass& pass : kPasses) {
    if (columns > pass.column && rows > pass.row) all += (rows - pass.row + pass.row_step - 1) / pass.row_step;
  }
  return all;
}

}  // namespace

void PngRows::Free::operator()(spng_ctx* context) const { spng_ctx_free(context); }

PngRows::PngRows(PngBytes bytes, std::uint64_t most_bytes)
    : bytes_(bytes), left_(most_bytes), context_(spng_ctx_new(0)) {}

PngRows::~PngRows() = default;

int PngRows::read(spng_ctx* /*context*/, void* user, void* to, std::size_t length) {
  PngRows& rows = *static_cast<PngRows*>(user);
  if (length > rows.left_) {
    rows.too_long_ = true;
    return SPNG_IO_ERROR;
  }
  rows.left_ -= length;
  std::span<std::byte> rest(static_cast<std::byte*>(to), length);
  while (!rest.empty()) {
    const auto got = rows.bytes_(rest);
    if (!got) {
      rows.error_ = got.error();
      return SPNG_IO_ERROR;
    }
    if (*got == 0) return SPNG_IO_EOF;
    rest = rest.subspan(*got);
  }
  return 0;
}

Status PngRows::result(int reason) const {
  if (reason == 0) return {};
  if (error_) return tl::unexpected<Error>(*error_);
  if (too_long_) return fail(ErrorCode::kMalformed, "is longer than a mask can be.\tExport the layers again");
  if (reason == SPNG_EMEM) return fail(ErrorCode::kOutOfMemory, "no memory for its rows");
  return fail(ErrorCode::kMalformed, "cannot be read as PNG (%s).\tExport the layers again", spng_strerror(reason));
}

Expected<PngHeader> PngRows::header() {
  if (!context_) return tl::unexpected<Error>(result(SPNG_EMEM).error());
  constexpr std::size_t kLargestChunk = 65536;  // that is kept: a palette, a text
  spng_set_chunk_limits(context_.get(), kLargestChunk, kLargestChunk);
  spng_ihdr facts = {};
  int reason = spng_set_png_stream(context_.get(), read, this);
  if (reason == 0) reason = spng_get_ihdr(context_.get(), &facts);
  PLUMBLINE_TRY(result(reason));
  PngHeader header{.columns = facts.width,
                   .rows = facts.height,
                   .depth = facts.bit_depth,
                   .channels = 1,
                   .is_grey = false,
                   .is_interlaced = facts.interlace_method != SPNG_INTERLACE_NONE};
  rows_ = header.is_interlaced ? interlaced_rows(facts.width, facts.height) : facts.height;
  switch (facts.color_type) {
    case SPNG_COLOR_TYPE_GRAYSCALE: header.is_grey = true; break;
    case SPNG_COLOR_TYPE_GRAYSCALE_ALPHA:
      header.is_grey = true;
      header.channels = 2;
      break;
    case SPNG_COLOR_TYPE_TRUECOLOR: header.channels = 3; break;
    case SPNG_COLOR_TYPE_TRUECOLOR_ALPHA: header.channels = 4; break;
    default: break;  // a palette
  }
  return header;
}

Status PngRows::begin(Form form) {
  const int format = form == Form::kRgba ? SPNG_FMT_RGBA8 : SPNG_FMT_RAW;
  const int flags = SPNG_DECODE_PROGRESSIVE | (form == Form::kRgba ? SPNG_DECODE_TRNS : 0);
  return result(spng_decode_image(context_.get(), nullptr, 0, format, flags));
}

Expected<std::uint32_t> PngRows::next(std::span<unsigned char> line) {
  spng_row_info at = {};
  PLUMBLINE_TRY(result(spng_get_row_info(context_.get(), &at)));
  const int reason = spng_decode_row(context_.get(), line.data(), line.size());
  PLUMBLINE_TRY(result(--rows_ == 0 && reason == SPNG_EOI ? 0 : reason));
  return at.row_num;
}

Status PngRows::finish() { return result(spng_decode_chunks(context_.get())); }

}  // namespace plumbline
