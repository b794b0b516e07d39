#include "firmware/print/store/journal.hpp"

#include <algorithm>
#include <array>
#include <cassert>
#include <cstring>
#include <type_traits>

#include "firmware/io/hash64.hpp"

namespace plumbline {
namespace {

constexpr std::uint32_t kHeaderMagic = 0x314A4C50;  // "PLJ1"
constexpr std::uint32_t kRecordMagic = 0x524A4C50;  // "PLJR"

/// As on the medium: little-endian, no padding. The hash covers the bytes before it.
struct Header {
  std::uint32_t magic = kHeaderMagic;
  std::uint32_t layers = 0;
  std::uint64_t job_hash = 0;
  std::array<std::uint64_t, 5> reserved = {};
  std::uint64_t hash = 0;
};

struct Record {
  std::uint32_t magic = kRecordMagic;
  std::uint32_t next_layer = 0;
  std::uint64_t sequence = 0;  ///< from 1
  std::uint64_t job_hash = 0;
  std::int64_t height_nm = 0;
  std::uint64_t cured_pixels = 0;
  std::int64_t elapsed_ns = 0;
  std::int64_t lit_ns = 0;
  std::uint64_t hash = 0;
};

static_assert(sizeof(Header) == Journal::kRecordBytes && std::has_unique_object_representations_v<Header>);
static_assert(sizeof(Record) == Journal::kRecordBytes && std::has_unique_object_representations_v<Record>);

using Bytes = std::array<std::byte, Journal::kRecordBytes>;
constexpr std::size_t kHashAt = Journal::kRecordBytes - sizeof(std::uint64_t);

std::uint64_t hash_of(std::span<const std::byte> bytes) {
  Hash64 hash;
  hash.add(bytes.first(kHashAt));
  const std::uint64_t value = hash.value();
  return value != 0 ? value : 1;  // 0 would look like a hash that was not written
}

template <class T>
Bytes sealed(T value) {
  value.hash = hash_of(std::as_bytes(std::span(&value, 1)));
  Bytes bytes;
  std::memcpy(bytes.data(), &value, sizeof value);
  return bytes;
}

enum class Found : std::uint8_t { kWhole, kNothing, kCutShort, kDamaged };

/// @param expected  the first bytes of every valid record
Found judge(const Bytes& bytes, std::span<const std::byte> expected) {
  const auto last = std::find_if(bytes.rbegin(), bytes.rend(), [](std::byte byte) { return byte != std::byte{0}; });
  const auto written = static_cast<std::size_t>(bytes.rend() - last);  // up to the last byte that is not zero
  if (written == 0) return Found::kNothing;
  const std::size_t start = std::min(written, expected.size());
  if (!std::equal(bytes.begin(), bytes.begin() + static_cast<std::ptrdiff_t>(start), expected.begin())) {
    return Found::kDamaged;
  }
  if (written <= kHashAt) return Found::kCutShort;
  // As much of the hash as was written must be right.
  const std::uint64_t hash = hash_of(bytes);
  const auto right = std::as_bytes(std::span(&hash, 1));
  if (std::equal(bytes.begin() + kHashAt, bytes.end(), right.begin())) return Found::kWhole;
  return std::equal(bytes.begin() + kHashAt, bytes.begin() + static_cast<std::ptrdiff_t>(written), right.begin())
             ? Found::kCutShort
             : Found::kDamaged;
}

tl::unexpected<Error> damaged(std::size_t record, const char* how) {
  return fail(ErrorCode::kMalformed, "the journal of the interrupted print is damaged at record %zu: %s", record, how);
}

}  // namespace

Expected<Journal> Journal::create(JournalStorage& storage, std::uint64_t job_hash, std::uint32_t layers) {
  assert(storage.size() >= bytes_needed(layers));
  Journal journal(storage);
  journal.job_hash_ = job_hash;
  journal.layers_ = layers;
  Header header;
  header.layers = layers;
  header.job_hash = job_hash;
  PLUMBLINE_TRY(storage.write(0, sealed(header)));
  PLUMBLINE_TRY(storage.sync());
  return journal;
}

Expected<Journal> Journal::open(JournalStorage& storage) {
  Journal journal(storage);
  Bytes bytes{};
  if (storage.size() < kRecordBytes) return fail(ErrorCode::kTruncated, "no journal: the file is too short");
  PLUMBLINE_TRY(storage.read(0, bytes));
  switch (judge(bytes, std::as_bytes(std::span(&kHeaderMagic, 1)))) {
    case Found::kNothing:
    case Found::kCutShort:
      return fail(ErrorCode::kTruncated, "no journal: the print was interrupted before its first layer");
    case Found::kDamaged: return damaged(0, "its hash is wrong");
    case Found::kWhole: break;
  }
  Header header;
  std::memcpy(&header, bytes.data(), sizeof header);
  if (header.layers == 0 || storage.size() < bytes_needed(header.layers)) return damaged(0, "the file is cut off");
  journal.job_hash_ = header.job_hash;
  journal.layers_ = header.layers;

  const std::size_t capacity = storage.size() / kRecordBytes - 1;
  bool ended = false;
  for (std::size_t i = 1; i <= capacity; ++i) {
    PLUMBLINE_TRY(storage.read(i * kRecordBytes, bytes));
    const Found found = judge(bytes, std::as_bytes(std::span(&kRecordMagic, 1)));
    if (found == Found::kNothing) {
      ended = true;
      continue;
    }
    if (found == Found::kDamaged) return damaged(i, "its hash is wrong");
    if (ended) return damaged(i, "it comes after the end");
    if (found == Found::kCutShort) {
      journal.cut_short_ = true;
      ended = true;
      continue;
    }
    Record record;
    std::memcpy(&record, bytes.data(), sizeof record);
    if (record.sequence != i || record.job_hash != header.job_hash) return damaged(i, "it belongs to another journal");
    const std::uint32_t before = journal.last_.next_layer;
    if (record.next_layer > header.layers || (record.next_layer != before && record.next_layer != before + 1)) {
      return damaged(i, "it skips a layer");
    }
    journal.last_ = {.next_layer = record.next_layer,
                     .height = ZPosition(Distance::nanometres(record.height_nm)),
                     .cured_pixels = record.cured_pixels,
                     .elapsed = nanoseconds(record.elapsed_ns),
                     .lit = nanoseconds(record.lit_ns)};
    journal.records_ = i;
  }
  return journal;
}

Status Journal::append(const JournalEntry& entry) {
  assert(entry.next_layer == last_.next_layer || entry.next_layer == last_.next_layer + 1);
  const std::size_t at = records_ + 1;
  if ((at + 1) * kRecordBytes > storage_->size()) {
    return fail(ErrorCode::kCannotWrite, "the journal is full: the print has been interrupted too often");
  }
  Record record;
  record.next_layer = entry.next_layer;
  record.sequence = at;
  record.job_hash = job_hash_;
  record.height_nm = entry.height.above_film().nanometres();
  record.cured_pixels = entry.cured_pixels;
  record.elapsed_ns = entry.elapsed.count();
  record.lit_ns = entry.lit.count();
  PLUMBLINE_TRY(storage_->write(at * kRecordBytes, sealed(record)));
  PLUMBLINE_TRY(storage_->sync());
  records_ = at;
  last_ = entry;
  return {};
}

}  // namespace plumbline
