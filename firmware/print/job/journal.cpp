#include "firmware/print/job/journal.hpp"

#include <algorithm>
#include <array>
#include <cassert>
#include <cstring>
#include <limits>
#include <type_traits>
#include <utility>

#include "firmware/io/hash64.hpp"
#include "slicer/core/print_grid.hpp"

namespace plumbline::firmware {
namespace {

constexpr std::uint32_t kJournalMagic = 0x334A4C50;  // "PLJ3"
/// "PLJ1" has one copy, with zeros where no record is; the records of "PLJ2" have no pixels of the layer at hand.
constexpr std::array<std::uint32_t, 2> kOlderMagics = {0x314A4C50, 0x324A4C50};
constexpr std::size_t kCopies = 2;
/// `Record::next_layer` of a slot without a record.
constexpr std::uint32_t kSeal = std::numeric_limits<std::uint32_t>::max();

/// As on the medium: little-endian, no padding. The hash covers the bytes before it.
struct Header {
  std::uint32_t magic = kJournalMagic;
  std::uint32_t layers = 0;
  std::uint64_t job_hash = 0;
  std::array<std::uint64_t, 5> reserved = {};
  std::uint64_t hash = 0;
};

struct Record {
  std::uint32_t next_layer = kSeal;
  std::uint32_t slot = 0;  ///< from 1
  std::uint64_t job_hash = 0;
  std::int64_t height_nm = 0;
  std::int64_t stands_nm = 0;
  std::uint64_t cured_pixels = 0;
  std::uint32_t at_hand_pixels = 0;
  std::uint32_t elapsed_ms = 0;
  std::uint32_t lit_us = 0;
  std::uint32_t lamp_ms = 0;
  std::uint64_t hash = 0;
};

static_assert(sizeof(Header) == Journal::kRecordBytes && std::has_unique_object_representations_v<Header>);
static_assert(sizeof(Record) == Journal::kRecordBytes && std::has_unique_object_representations_v<Record>);

using Bytes = std::array<std::byte, Journal::kRecordBytes>;
using JournalPage = std::array<Bytes, Journal::kPageBytes / Journal::kRecordBytes>;

template <class Unit>
std::uint32_t whole(nanoseconds time) {
  return static_cast<std::uint32_t>(std::chrono::duration_cast<Unit>(time).count());
}

template <class T>
std::uint64_t hash_of(const T& value) {
  Hash64 hash;
  hash.add(std::as_bytes(std::span(&value, 1)).first(sizeof value - sizeof value.hash));
  return hash.value();
}

template <class T>
Bytes sealed(T value) {
  value.hash = hash_of(value);
  Bytes bytes;
  std::memcpy(bytes.data(), &value, sizeof value);
  return bytes;
}

/// @returns whether the hash is right
template <class T>
bool unseal(const Bytes& bytes, T& value) {
  std::memcpy(&value, bytes.data(), sizeof value);
  return value.hash == hash_of(value);
}

tl::unexpected<Error> damaged_journal(std::size_t record, const char* how) {
  return fail(ErrorCode::kMalformed, "the journal of the interrupted print is damaged at record %zu: %s", record, how);
}

/// @param place  of the header
/// @returns whether it is whole
Expected<bool> read_header(JournalStorage& storage, std::size_t place, Header& header) {
  Bytes bytes{};
  PLUMBLINE_TRY(storage.read(place, bytes));
  const bool is_whole = unseal(bytes, header) && header.layers > 0 && header.layers <= PrintGrid::kMaxLayers;
  if (is_whole && std::ranges::find(kOlderMagics, header.magic) != kOlderMagics.end()) {
    return fail(ErrorCode::kUnsupported,
                "the interrupted print was started by an older version of plumbline; only that one can resume it");
  }
  return is_whole && header.magic == kJournalMagic;
}

/// Reads both headers; one of them is enough.
Status find_header(JournalStorage& storage, Header& header) {
  const std::size_t size = storage.size();
  if (size == 0) return fail(ErrorCode::kTruncated, "no journal: the file is empty");
  if (size < Journal::kRecordBytes) return damaged_journal(0, "the file is cut off");
  const auto first = read_header(storage, 0, header);
  PLUMBLINE_TRY(first);
  if (size < Journal::bytes_needed(1)) return damaged_journal(0, "the file is cut off");
  Header other;
  const auto second = read_header(storage, size / kCopies, other);
  PLUMBLINE_TRY(second);
  if (!*first && !*second) {
    const Header zeros{.magic = 0};
    const auto blank = [&zeros](const Header& found) { return std::memcmp(&found, &zeros, sizeof found) == 0; };
    if (blank(header) && blank(other)) return fail(ErrorCode::kTruncated, "no journal: nothing was written to it");
    return damaged_journal(0, "both copies have lost their header");
  }
  if (*first && *second && std::memcmp(&header, &other, sizeof header) != 0)
    return damaged_journal(0, "the headers differ");
  if (!*first) header = other;
  if (size != Journal::bytes_needed(header.layers)) return damaged_journal(0, "the file has another size");
  return {};
}

}  // namespace

Expected<Journal> Journal::create(JournalStorage& storage, std::uint64_t job_hash, std::uint32_t layers) {
  Journal journal(storage, job_hash, layers);
  JournalPage page;
  for (std::size_t copy = 0; copy < kCopies; ++copy) {
    for (std::size_t slot = 0; slot < journal.slots(); ++slot) {
      Bytes& bytes = page[slot % page.size()];
      bytes = slot == 0 ? sealed(Header{.layers = layers, .job_hash = job_hash})
                        : sealed(Record{.slot = static_cast<std::uint32_t>(slot), .job_hash = job_hash});
      if ((slot + 1) % page.size() != 0) continue;
      const std::size_t first = slot + 1 - page.size();
      PLUMBLINE_TRY(storage.write(journal.place_of(copy, first), std::as_bytes(std::span(page))));
    }
  }
  PLUMBLINE_TRY(storage.sync());
  return journal;
}

Expected<Journal> Journal::open(JournalStorage& storage) {
  Header header;
  PLUMBLINE_TRY(find_header(storage, header));
  Journal journal(storage, header.job_hash, header.layers);
  PLUMBLINE_TRY(journal.read_records());
  return journal;
}

/// Finds the last record and checks that nothing but the power cut that ended the journal can have made its state.
Status Journal::read_records() {
  std::array<std::size_t, kCopies> last = {};     // slots
  std::array<std::size_t, kCopies> spoiled = {};  // the last ones; 0: none
  std::array<JournalPage, kCopies> pages;
  for (std::size_t slot = 0; slot < slots(); ++slot) {
    const std::size_t in_page = slot % pages[0].size();
    for (std::size_t copy = 0; in_page == 0 && copy < kCopies; ++copy) {
      PLUMBLINE_TRY(storage_->read(place_of(copy, slot), std::as_writable_bytes(std::span(pages[copy]))));
    }
    if (slot == 0) continue;  // the header
    Record record;
    for (std::size_t copy = 0; copy < kCopies; ++copy) {
      Record here;
      if (!unseal(pages[copy][in_page], here) || here.slot != slot || here.job_hash != job_hash_) {
        spoiled[copy] = slot;
      } else if (here.next_layer != kSeal) {
        if (record.next_layer != kSeal && record.hash != here.hash)
          return damaged_journal(slot, "the two copies differ");
        record = here;
        last[copy] = slot;
      }
    }
    if (record.next_layer == kSeal) continue;
    if (slot != records_ + 1) return damaged_journal(records_ + 1, "both copies have lost it");
    const std::uint32_t before = last_.next_layer;
    if (record.next_layer > layers_ || (record.next_layer != before && record.next_layer != before + 1)) {
      return damaged_journal(slot, "it skips a layer");
    }
    last_ = {.next_layer = record.next_layer,
             .height = ZPosition(Distance::nanometres(record.height_nm)),
             .stands = ZPosition(Distance::nanometres(record.stands_nm)),
             .cured_pixels = record.cured_pixels,
             .at_hand_pixels = record.at_hand_pixels,
             .elapsed = std::chrono::milliseconds(record.elapsed_ms),
             .lit = std::chrono::microseconds(record.lit_us),
             .lamp = std::chrono::milliseconds(record.lamp_ms)};
    records_ = slot;
  }
  // The second copy may be one record behind, and the next write of either may be spoiled.
  if (last[0] != records_ || last[1] + 1 < records_) {
    return damaged_journal(std::min(last[0], last[1]) + 1, "one copy has lost it and all that came after it");
  }
  second_behind_ = last[1] != records_;
  if (spoiled[0] > records_ + (second_behind_ ? 0 : 1) || spoiled[1] > records_) {
    return damaged_journal(std::max(spoiled[0], spoiled[1]), "it is after the journal's end and not empty");
  }
  return {};
}

Status Journal::append(const JournalEntry& entry) {
  assert(entry.next_layer == last_.next_layer || entry.next_layer == last_.next_layer + 1);
  // What a failed write has left in the copies is unknown.
  if (std::exchange(failed_, true)) return fail(ErrorCode::kCannotWrite, "the journal could not be written before");
  const std::size_t slot = records_ + 1;
  if (slot >= slots()) {
    return fail(ErrorCode::kCannotWrite, "the journal is full: the print has been interrupted too often");
  }
  // A power cut has left it a record behind. One more would leave two, which looks like a copy that has lost its end.
  if (second_behind_) PLUMBLINE_TRY(store(1, records_, last_));
  for (std::size_t copy = 0; copy < kCopies; ++copy) PLUMBLINE_TRY(store(copy, slot, entry));
  second_behind_ = false;
  failed_ = false;
  records_ = slot;
  last_ = entry;
  return {};
}

Status Journal::store(std::size_t copy, std::size_t slot, const JournalEntry& entry) {
  const Bytes bytes = sealed(Record{.next_layer = entry.next_layer,
                                    .slot = static_cast<std::uint32_t>(slot),
                                    .job_hash = job_hash_,
                                    .height_nm = entry.height.above_film().nanometres(),
                                    .stands_nm = entry.stands.above_film().nanometres(),
                                    .cured_pixels = entry.cured_pixels,
                                    .at_hand_pixels = entry.at_hand_pixels,
                                    .elapsed_ms = whole<std::chrono::milliseconds>(entry.elapsed),
                                    .lit_us = whole<std::chrono::microseconds>(entry.lit),
                                    .lamp_ms = whole<std::chrono::milliseconds>(entry.lamp)});
  PLUMBLINE_TRY(storage_->write(place_of(copy, slot), bytes));
  PLUMBLINE_TRY(storage_->sync());
  // Worn-out cards take writes and drop them.
  Bytes kept{};
  PLUMBLINE_TRY(storage_->read(place_of(copy, slot), kept));
  if (kept == bytes) return {};
  return fail(ErrorCode::kCannotWrite,
              "the journal can't be written: the storage did not keep what it was given.\tReplace the storage");
}

}  // namespace plumbline::firmware
