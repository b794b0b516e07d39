#include "firmware/pictures/png.hpp"

#include <spng.h>

#include <algorithm>
#include <cassert>
#include <cstring>
#include <new>

#include "slicer/core/print_grid.hpp"

namespace plumbline::firmware::inline pictures {
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

/// What libspng and zlib take in this thread, one block after another, none of which is given back before the file is done.
struct {
  std::uint8_t* next = nullptr;  ///< null: they use the heap
  std::size_t left = 0;
} thread_local given;

constexpr std::size_t kAligned = 16;  ///< before each block: its size

void* take_block(std::size_t count) {
  const std::size_t rounded = (count + kAligned - 1) / kAligned * kAligned;
  if (rounded < count || given.left < kAligned || rounded > given.left - kAligned) return nullptr;
  std::memcpy(given.next, &count, sizeof count);
  void* const block = given.next + kAligned;
  given.next += kAligned + rounded;
  given.left -= kAligned + rounded;
  return block;
}
void* take_clear(std::size_t count, std::size_t size) {
  if (size != 0 && count > SIZE_MAX / size) return nullptr;
  void* const block = take_block(count * size);
  return block != nullptr ? std::memset(block, 0, count * size) : nullptr;
}
void* take_more(void* block, std::size_t count) {
  void* const more = take_block(count);
  if (more == nullptr || block == nullptr) return more;
  std::size_t had = 0;
  std::memcpy(&had, static_cast<std::uint8_t*>(block) - kAligned, sizeof had);
  return std::memcpy(more, block, std::min(had, count));
}
void give_back(void* /*block*/) {}

/// While it lives, libspng uses `memory`.
class Given {
 public:
  explicit Given(const PngBuffer& memory) { given = {memory.bytes.get(), memory.size}; }
  ~Given() { given = {}; }
  Given(const Given&) = delete;
  Given& operator=(const Given&) = delete;
};

spng_ctx* make_context(int flags) {
  if (given.next == nullptr) return spng_ctx_new(flags);
  spng_alloc blocks{take_block, take_more, take_clear, give_back};
  return spng_ctx_new2(&blocks, flags);
}

}  // namespace

void PngRows::Free::operator()(spng_ctx* context) const { spng_ctx_free(context); }

PngRows::PngRows(PngBytes bytes, std::uint64_t most_bytes)
    : bytes_(bytes), left_(most_bytes), context_(make_context(0)) {}

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

bool PngBuffer::take(std::size_t count) {
  bytes.reset(new (std::nothrow) std::uint8_t[count]);
  size = count;
  return bytes != nullptr;
}

Expected<PngWriter> PngWriter::create(std::size_t most_bytes) {
  constexpr std::size_t kRest = 65536;  // frames of the chunks
  // zlib has 268 KB, libspng a few rows, each of at most 64 KB.
  constexpr std::size_t kMemory = 640 * 1024;
  PngWriter writer;
  // What does not compress: deflateBound().
  if (!writer.file_.take(most_bytes + most_bytes / 8 + most_bytes / 64 + kRest) || !writer.memory_.take(kMemory)) {
    return fail(ErrorCode::kOutOfMemory, "PNG encoder: no memory");
  }
  return writer;
}

std::span<const std::byte> PngWriter::write(const Format& format,
                                            FunctionRef<std::span<const std::uint8_t>(std::uint32_t)> row) {
  const Given memory(memory_);
  std::span<std::uint8_t> rest(file_.bytes.get(), file_.size);
  const auto keep = [](spng_ctx* /*context*/, void* user, void* from, std::size_t length) -> int {
    auto& to = *static_cast<std::span<std::uint8_t>*>(user);
    if (length > to.size()) return SPNG_IO_ERROR;
    std::memcpy(to.data(), from, length);
    to = to.subspan(length);
    return 0;
  };
  spng_ctx* const context = make_context(SPNG_CTX_ENCODER);
  spng_ihdr header{};
  header.width = format.columns;
  header.height = format.rows;
  header.bit_depth = format.depth;
  header.color_type = format.channels == 3 ? SPNG_COLOR_TYPE_TRUECOLOR : SPNG_COLOR_TYPE_GRAYSCALE;
  const auto set = [context](spng_option option, int value) { return spng_set_option(context, option, value); };
  int reason = spng_set_png_stream(context, keep, &rest);
  if (reason == 0) reason = spng_set_ihdr(context, &header);
  if (format.is_mask) {
    constexpr int kRuns = 3;  // Z_RLE of zlib.h
    // Runs alone, with small blocks: faster and smaller than any level that searches.
    set(SPNG_FILTER_CHOICE, SPNG_FILTER_CHOICE_NONE);
    set(SPNG_IMG_COMPRESSION_LEVEL, 1);
    set(SPNG_IMG_COMPRESSION_STRATEGY, kRuns);
    set(SPNG_IMG_MEM_LEVEL, 4);
  } else {
    set(SPNG_FILTER_CHOICE, SPNG_FILTER_CHOICE_UP);
  }
  constexpr int kRowByRow = SPNG_ENCODE_PROGRESSIVE | SPNG_ENCODE_FINALIZE;
  if (reason == 0) reason = spng_encode_image(context, nullptr, 0, SPNG_FMT_PNG, kRowByRow);
  for (std::uint32_t r = 0; r < format.rows && reason == 0; ++r) {
    const auto bytes = row(r);
    reason = spng_encode_row(context, bytes.data(), bytes.size());
  }
  assert(reason == SPNG_EOI && "create() was given too few bytes");
  return std::as_bytes(
      std::span<const std::uint8_t>(file_.bytes.get(), reason == SPNG_EOI ? file_.size - rest.size() : 0));
}

PngEncoder::PngEncoder(PngWriter writer, std::uint32_t columns, MaskDepth depth)
    : writer_(std::move(writer)), depth_(depth), row_(columns + std::size_t{63}) {}

Expected<PngEncoder> PngEncoder::for_masks(std::uint32_t columns, std::uint32_t rows, MaskDepth depth) {
  const std::size_t row_bytes = depth == MaskDepth::kBit ? (columns + std::size_t{7}) / 8 : columns;
  auto writer = PngWriter::create((1 + row_bytes) * rows);
  PLUMBLINE_TRY(writer);
  return PngEncoder(std::move(*writer), columns, depth);
}

std::span<const std::byte> PngEncoder::encode(ConstBitImage mask, std::span<const GreyRun> greys) {
  const std::size_t last = mask.stride() - std::size_t{1};
  const auto words = [&](std::uint32_t r, std::size_t w) {
    return mask.row(r)[w] & (w == last ? mask.last_word_mask() : ~std::uint64_t{0});
  };
  const auto bits = [&](std::uint32_t r) -> std::span<const std::uint8_t> {
    for (std::size_t w = 0; w <= last; ++w) {
      const std::uint64_t word = __builtin_bswap64(reversed_bits(words(r, w)));
      std::memcpy(&row_[8 * w], &word, sizeof word);
    }
    return std::span(row_).first((mask.columns() + std::size_t{7}) / 8);
  };
  const auto bytes = [&](std::uint32_t r) -> std::span<const std::uint8_t> {
    for (std::size_t w = 0; w <= last; ++w) {
      const std::uint64_t word = words(r, w);
      std::uint8_t* const at = &row_[64 * w];
      if (word == 0 || ~word == 0) {
        std::memset(at, static_cast<int>(word & 0xFFU), 64);
      } else {
        for (unsigned i = 0; i < 64; ++i) at[i] = (word >> i & 1U) != 0 ? 255 : 0;
      }
    }
    for (; !greys.empty() && greys.front().pixel / mask.columns() == r; greys = greys.subspan(1)) {
      std::memset(&row_[greys.front().pixel % mask.columns()], greys.front().level, greys.front().count);
    }
    return std::span(row_).first(mask.columns());
  };
  const bool has_bytes = depth_ == MaskDepth::kByte || (depth_ == MaskDepth::kNeeded && !greys.empty());
  const PngWriter::Format format{mask.columns(), mask.rows(), static_cast<std::uint8_t>(has_bytes ? 8 : 1), 1, true};
  return has_bytes ? writer_.write(format, bytes) : writer_.write(format, bits);
}

Expected<PictureEncoder> PictureEncoder::create(std::size_t most_bytes) {
  auto writer = PngWriter::create(2 * most_bytes);  // each row has a byte more
  PLUMBLINE_TRY(writer);
  return PictureEncoder(std::move(*writer));
}

std::span<const std::byte> PictureEncoder::encode(std::span<const std::uint8_t> pixels, std::uint32_t columns,
                                                  std::uint32_t rows, std::uint32_t channels) {
  const std::size_t width = std::size_t{channels} * columns;
  return writer_.write({columns, rows, 8, static_cast<std::uint8_t>(channels)},
                       [&](std::uint32_t r) { return pixels.subspan(r * width, width); });
}

Expected<PictureDecoder> PictureDecoder::create() {
  PictureDecoder decoder;
  // zlib has 44 KB, libspng a few rows.
  if (!decoder.memory_.take(std::size_t{256} * 1024)) return fail(ErrorCode::kOutOfMemory, "PNG decoder: no memory");
  return decoder;
}

Expected<PngSize> PictureDecoder::decode(std::span<const std::byte> file, std::uint32_t channels, PngSize most,
                                         std::span<std::uint8_t> pixels) {
  const Given memory(memory_);
  const auto malformed = [] { return fail(ErrorCode::kMalformed, "the picture is damaged"); };
  BytesOf bytes{file};
  PngRows rows(bytes, file.size());
  const auto header = rows.header();
  if (!header || header->depth != 8 || header->channels != channels || header->is_grey != (channels == 1) ||
      header->is_interlaced) {
    return malformed();
  }
  const PngSize size{header->columns, header->rows};
  const std::size_t width = std::size_t{channels} * size.columns;
  if (size.columns > most.columns || size.rows > most.rows || width * size.rows > pixels.size()) {
    return fail(ErrorCode::kUnsupported, "the picture has %u x %u pixels", size.columns, size.rows);
  }
  if (!rows.begin(PngRows::Form::kAsStored)) return malformed();
  for (std::uint32_t r = 0; r < size.rows; ++r) {
    if (!rows.next(pixels.subspan(r * width, width))) return malformed();
  }
  if (!rows.finish()) return malformed();
  return size;
}

Expected<PngSize> png_size(std::span<const std::byte> file) {
  BytesOf bytes{file};
  PngRows rows(bytes, file.size());
  const auto header = rows.header();
  PLUMBLINE_TRY(header);
  if (header->columns > PrintGrid::kMaxSide || header->rows > PrintGrid::kMaxSide) {
    return fail(ErrorCode::kUnsupported, "has %u x %u pixels, at most %u x %u are allowed", header->columns,
                header->rows, PrintGrid::kMaxSide, PrintGrid::kMaxSide);
  }
  return PngSize{header->columns, header->rows};
}

Expected<std::size_t> BytesOf::operator()(std::span<std::byte> to) {
  const std::size_t count = std::min(to.size(), file.size());
  std::copy_n(file.begin(), count, to.begin());
  file = file.subspan(count);
  return count;
}

}  // namespace plumbline::firmware::inline pictures
