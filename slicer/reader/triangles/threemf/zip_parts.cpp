#include "slicer/reader/triangles/threemf/zip_parts.hpp"

#include <algorithm>

#include "slicer/reader/stream/words.hpp"

namespace plumbline::inline slicer {
namespace {

constexpr std::uint64_t kPart = 0x04034b50;        ///< signature of a part's header
constexpr std::uint64_t kDescriptor = 0x08074b50;  ///< of the sizes that follow a part, where it is not left out
constexpr std::uint64_t kDirectory = 0x02014b50;
constexpr std::uint64_t kDirectoryEnd = 0x06054b50;
constexpr std::size_t kHeadBytes = 30;
constexpr unsigned kEncrypted = 1;
constexpr unsigned kSizesFollow = 8;
constexpr unsigned kStored = 0;
constexpr unsigned kDeflated = 8;
constexpr std::uint64_t kLongSize = 0xffffffff;  ///< the size is in an extra field of 64 bits
constexpr std::uint64_t kLongSizes = 1;          ///< that field's number

}  // namespace

std::uint64_t ZipParts::load(std::size_t at, std::size_t bytes) const {
  std::uint64_t number = 0;
  for (std::size_t i = 0; i < bytes; ++i) {
    number |= std::uint64_t{static_cast<unsigned char>(input_.begin()[at + i])} << (8 * i);
  }
  return number;
}

Status ZipParts::need(std::size_t bytes) {
  const auto ready = input_.fill(bytes);
  PLUMBLINE_TRY(ready);
  if (*ready >= bytes) return {};
  return input_.fail(ErrorCode::kTruncated, "the file ends at byte %llu, before its archive does;\tcopy it again",
                     static_cast<unsigned long long>(input_.bytes_read()));
}

Expected<bool> ZipParts::next() {
  PLUMBLINE_TRY(finish_part());
  PLUMBLINE_TRY(need(4));
  const std::uint64_t signature = load(0, 4);
  if (signature == kDirectory || signature == kDirectoryEnd) return false;
  if (signature != kPart) {
    return input_.fail(ErrorCode::kMalformed,
                       "byte %llu: expected the header of a part of the archive; the file is damaged.\tExport it again",
                       static_cast<unsigned long long>(input_.offset()));
  }
  PLUMBLINE_TRY(read_head());
  return true;
}

Status ZipParts::read_head() {
  PLUMBLINE_TRY(need(kHeadBytes));
  const auto flags = static_cast<unsigned>(load(6, 2));
  encrypted_ = (flags & kEncrypted) != 0;
  sizes_follow_ = (flags & kSizesFollow) != 0;
  method_ = static_cast<unsigned>(load(8, 2));
  checksum_ = static_cast<std::uint32_t>(load(14, 4));
  left_ = load(18, 4);
  const auto name_bytes = static_cast<std::size_t>(load(26, 2));
  const auto extra_bytes = static_cast<std::size_t>(load(28, 2));
  input_.consume(kHeadBytes);
  name_size_ = 0;
  if (name_bytes <= name_.size()) {
    PLUMBLINE_TRY(need(name_bytes));
    std::copy_n(input_.begin(), name_bytes, name_.begin());
    name_size_ = name_bytes;
    input_.consume(name_bytes);
  } else {
    PLUMBLINE_TRY(input_.skip(name_bytes));
  }
  PLUMBLINE_TRY(find_long_size(extra_bytes));
  open_ = true;
  touched_ = false;
  sum_ = 0;
  inflate_.restart();
  if (!sizes_follow_ || (method_ == kDeflated && !encrypted_)) return {};
  // Some writers set the bit and give the size all the same.
  if (left_ > 0 && !encrypted_) {
    sizes_follow_ = false;
    return {};
  }
  const auto at = static_cast<unsigned long long>(input_.offset());
  if (encrypted_) {
    return input_.fail(ErrorCode::kUnsupported,
                       "byte %llu: '%s' is encrypted;\texport the file again, without a password", at,
                       Quote(name()).c_str());
  }
  return input_.fail(
      ErrorCode::kUnsupported,
      "byte %llu: '%s' is not compressed and does not say how long it is;\texport the file again, compressed", at,
      Quote(name()).c_str());
}

/// Takes the extra fields of a header.
Status ZipParts::find_long_size(std::size_t bytes) {
  PLUMBLINE_TRY(need(bytes));
  for (std::size_t at = 0; at + 4 <= bytes && left_ == kLongSize && !sizes_follow_;) {
    const std::uint64_t field = load(at, 2);
    const auto size = static_cast<std::size_t>(load(at + 2, 2));
    if (at + 4 + size > bytes) break;
    if (field == kLongSizes && size >= 16) left_ = load(at + 12, 8);  // after the size when unpacked
    at += 4 + size;
  }
  input_.consume(bytes);
  return {};
}

Expected<std::span<const char>> ZipParts::piece() {
  if (method_ == kDeflated) return inflate_.next(InflateStream::kWindow);
  if (left_ == 0) return std::span<const char>();
  PLUMBLINE_TRY(need(1));
  const auto size = static_cast<std::size_t>(
      std::min<std::uint64_t>({left_, input_.available(), InflateStream::kWindow}));  // expat keeps a copy
  const std::span<const char> stored(input_.begin(), size);
  input_.consume(size);
  left_ -= size;
  return stored;
}

Expected<std::span<const char>> ZipParts::read() {
  if (encrypted_) {
    return input_.fail(ErrorCode::kUnsupported, "'%s' is encrypted;\texport the file again, without a password",
                       Quote(name()).c_str());
  }
  if (method_ != kStored && method_ != kDeflated) {
    return input_.fail(ErrorCode::kUnsupported,
                       "'%s' is packed by method %u of zip;\texport it with deflate (method 8)", Quote(name()).c_str(),
                       method_);
  }
  touched_ = true;
  const auto bytes = piece();
  PLUMBLINE_TRY(bytes);
  unpacked_ += bytes->size();
  if (unpacked_ > kMostUnpacked) {
    return input_.fail(ErrorCode::kUnsupported, "it has more than %llu GiB when it is unpacked.\tReduce its triangles",
                       static_cast<unsigned long long>(kMostUnpacked >> 30U));
  }
  if (!bytes->empty()) {
    sum_ = crc32_of(*bytes, sum_);
    return bytes;
  }
  if (sizes_follow_) PLUMBLINE_TRY(take_descriptor());
  open_ = false;
  if (sum_ == checksum_) return bytes;
  return input_.fail(ErrorCode::kMalformed,
                     "byte %llu: the checksum of '%s' is wrong; the file is damaged.\tCopy it again",
                     static_cast<unsigned long long>(input_.offset()), Quote(name()).c_str());
}

/// Takes the checksum and the sizes behind a part. The signature may be missing, and the sizes may have 32 or 64 bits: what follows
/// them tells.
Status ZipParts::take_descriptor() {
  PLUMBLINE_TRY(need(4));
  if (load(0, 4) == kDescriptor) input_.consume(4);
  PLUMBLINE_TRY(need(20));
  checksum_ = static_cast<std::uint32_t>(load(0, 4));
  const std::uint64_t after = load(12, 4);
  input_.consume(after == kPart || after == kDirectory ? 12 : 20);
  return {};
}

Status ZipParts::finish_part() {
  if (!open_) return {};
  if (!sizes_follow_ && !touched_) {
    open_ = false;
    const auto skipped = input_.skip(left_);
    PLUMBLINE_TRY(skipped);
    return {};
  }
  for (;;) {
    const auto bytes = read();
    PLUMBLINE_TRY(bytes);
    if (bytes->empty()) return {};
  }
}

}  // namespace plumbline::inline slicer
