#include "slicer/reader/stream/inflate_stream.hpp"

#include <zlib.h>

#include <algorithm>
#include <new>
#include <string_view>

namespace plumbline::inline slicer {

std::uint32_t crc32_of(std::span<const char> bytes, std::uint32_t before) {
  return static_cast<std::uint32_t>(
      ::crc32(before, reinterpret_cast<const Bytef*>(bytes.data()), static_cast<uInt>(bytes.size())));
}

InflateStream::InflateStream(ByteInput& input, Wrapping wrapping, std::span<char> window, std::span<std::byte> heap)
    : input_(input), window_(window), heap_(heap), is_gzip_(wrapping == Wrapping::kGzip) {
  void* const place = heap_.allocate(sizeof(z_stream));
  if (place == nullptr) return;
  auto* const zlib = new (place) z_stream();
  zlib->zalloc = [](voidpf own, uInt items, uInt size) -> voidpf {
    return static_cast<FixedHeap*>(own)->allocate(std::size_t{items} * size);
  };
  zlib->zfree = [](voidpf own, voidpf part) { static_cast<FixedHeap*>(own)->release(part); };
  zlib->opaque = &heap_;
  constexpr int kLargestWindow = 15;
  const int window_bits = is_gzip_ ? 16 + kLargestWindow : -kLargestWindow;
  if (inflateInit2(zlib, window_bits) == Z_OK) zlib_ = zlib;
}

InflateStream::~InflateStream() {
  if (zlib_ != nullptr) inflateEnd(zlib_);
}

void InflateStream::restart() {
  if (zlib_ != nullptr) inflateReset(zlib_);
  ended_ = false;
}

Expected<std::span<const char>> InflateStream::next(std::uint64_t most) {
  if (zlib_ == nullptr) return input_.fail(ErrorCode::kOutOfMemory, "no room for zlib");
  const auto wanted = static_cast<std::size_t>(std::min<std::uint64_t>(most, window_.size()));
  zlib_->next_out = reinterpret_cast<Bytef*>(window_.data());
  zlib_->avail_out = static_cast<uInt>(wanted);
  while (zlib_->avail_out == wanted && !ended_) {
    const auto ready = input_.fill(1);
    PLUMBLINE_TRY(ready);
    if (*ready == 0) {
      return input_.fail(ErrorCode::kTruncated,
                         "the file ends at byte %llu, before its compressed data does;\tcopy it again",
                         static_cast<unsigned long long>(input_.bytes_read()));
    }
    const auto given = static_cast<uInt>(std::min<std::size_t>(input_.available(), 1U << 30U));
    zlib_->next_in = reinterpret_cast<Bytef*>(const_cast<char*>(input_.begin()));
    zlib_->avail_in = given;
    const int outcome = inflate(zlib_, Z_NO_FLUSH);
    input_.consume(given - zlib_->avail_in);
    ended_ = outcome == Z_STREAM_END;
    if (ended_ && is_gzip_) {
      const auto follows = input_.fill(2);
      PLUMBLINE_TRY(follows);
      if (*follows >= 2 && std::string_view(input_.begin(), 2) == "\x1f\x8b") restart();
    }
    if (outcome != Z_OK && outcome != Z_STREAM_END) {
      return input_.fail(ErrorCode::kMalformed,
                         "byte %llu: the compressed data is damaged (%s);\tcopy or export the file again",
                         static_cast<unsigned long long>(input_.offset()), zlib_->msg != nullptr ? zlib_->msg : "zlib");
    }
  }
  return std::span<const char>(window_.data(), wanted - zlib_->avail_out);
}

}  // namespace plumbline::inline slicer
