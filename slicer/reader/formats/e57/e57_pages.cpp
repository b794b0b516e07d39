#include "slicer/reader/formats/e57/e57_pages.hpp"

#include <algorithm>
#include <array>
#include <cassert>
#include <cstring>

namespace plumbline::inline slicer {
namespace {

constexpr std::uint32_t kPolynomial = 0x82F63B78;  ///< bits reversed

/// Entry [k][b]: what byte b, followed by k zeros, does to the remainder. Eight bytes a step (Kounavis and Berry 2005).
constexpr auto kTables = [] {
  std::array<std::array<std::uint32_t, 256>, 8> tables{};
  for (std::uint32_t byte = 0; byte < 256; ++byte) {
    std::uint32_t rest = byte;
    for (int bit = 0; bit < 8; ++bit) rest = (rest >> 1) ^ ((rest & 1U) != 0 ? kPolynomial : 0);
    tables[0][byte] = rest;
  }
  for (std::size_t k = 1; k < 8; ++k) {
    for (std::size_t byte = 0; byte < 256; ++byte) {
      const std::uint32_t before = tables[k - 1][byte];
      tables[k][byte] = (before >> 8) ^ tables[0][before & 255U];
    }
  }
  return tables;
}();

}  // namespace

std::uint32_t crc32c(std::span<const char> bytes) {
  std::uint32_t rest = ~0U;
  const auto at = [&](std::size_t i) { return static_cast<std::uint32_t>(static_cast<unsigned char>(bytes[i])); };
  for (; bytes.size() >= 8; bytes = bytes.subspan(8)) {
    rest ^= at(0) | at(1) << 8 | at(2) << 16 | at(3) << 24;
    rest = kTables[7][rest & 255U] ^ kTables[6][rest >> 8 & 255U] ^ kTables[5][rest >> 16 & 255U] ^
           kTables[4][rest >> 24] ^ kTables[3][at(4)] ^ kTables[2][at(5)] ^ kTables[1][at(6)] ^ kTables[0][at(7)];
  }
  for (std::size_t i = 0; i < bytes.size(); ++i) rest = (rest >> 8) ^ kTables[0][(rest ^ at(i)) & 255U];
  return ~rest;
}

Status E57Pages::seek(std::uint64_t offset) {
  assert(offset >= this->offset());
  const std::uint64_t page = offset / kPayload;
  if (page != page_) {
    const std::uint64_t bytes = (page - page_) * kPage;
    const auto skipped = input_.skip(bytes);
    PLUMBLINE_TRY(skipped);
    if (*skipped < bytes) {
      return input_.fail(ErrorCode::kTruncated, "the file ends at byte %llu, but refers to byte %llu;\tcopy it again",
                         static_cast<unsigned long long>(input_.bytes_read()),
                         static_cast<unsigned long long>(page * kPage + offset % kPayload));
    }
    page_ = page;
    checked_ = false;
  }
  used_ = static_cast<std::size_t>(offset % kPayload);
  return {};
}

Status E57Pages::rewind() {
  PLUMBLINE_TRY(input_.rewind());
  page_ = used_ = 0;
  checked_ = false;
  return {};
}

Expected<std::span<const char>> E57Pages::next(std::uint64_t most) {
  assert(most > 0);
  if (!checked_) {
    const auto ready = input_.fill(kPage);
    PLUMBLINE_TRY(ready);
    if (*ready < kPage) {
      return input_.fail(ErrorCode::kTruncated,
                         "the file ends at byte %llu, within a page of %zu bytes;\tcopy it again",
                         static_cast<unsigned long long>(input_.bytes_read()), kPage);
    }
    const char* const page = input_.begin();
    const std::uint32_t found = crc32c({page, kPayload});
    for (std::size_t i = 0; i < 4; ++i) {  // the highest byte first
      if (static_cast<unsigned char>(page[kPayload + i]) == (found >> (24 - 8 * i) & 255U)) continue;
      return input_.fail(ErrorCode::kMalformed,
                         "byte %llu: the checksum of this page of %zu bytes is wrong: the file is damaged.\tCopy it "
                         "again",
                         static_cast<unsigned long long>(page_ * kPage), kPage);
    }
    checked_ = true;
  }
  const auto count = static_cast<std::size_t>(std::min<std::uint64_t>(most, kPayload - used_));
  const std::span<const char> bytes(input_.begin() + used_, count);
  used_ += count;
  if (used_ == kPayload) {
    input_.consume(kPage);  // the bytes stay where they are until the window is filled again
    ++page_;
    used_ = 0;
    checked_ = false;
  }
  return bytes;
}

Status E57Pages::read(std::span<char> to) {
  while (!to.empty()) {
    const auto bytes = next(to.size());
    PLUMBLINE_TRY(bytes);
    std::memcpy(to.data(), bytes->data(), bytes->size());
    to = to.subspan(bytes->size());
  }
  return {};
}

}  // namespace plumbline::inline slicer
