#include "firmware/print/job/journal.hpp"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <algorithm>
#include <array>
#include <cstring>
#include <random>
#include <vector>

#include "firmware/io/hash64.hpp"

namespace plumbline::firmware {
namespace journal_test {

using namespace plumbline::literals;
using namespace std::chrono_literals;
using ::testing::AnyOf;
using ::testing::HasSubstr;

constexpr std::uint32_t kLayers = 20;
constexpr std::size_t kCopy = Journal::copy_bytes(kLayers);
constexpr std::size_t kRecord = Journal::kRecordBytes;

/// A medium whose power fails: it keeps the first bytes of a write and none of the later writes.
class CutStorage final : public JournalStorage {
 public:
  explicit CutStorage(std::uint32_t layers = kLayers) : medium_(Journal::bytes_needed(layers)) {}
  explicit CutStorage(std::vector<std::byte> medium) : medium_(std::move(medium)) {}

  /// Stops writing after `bytes` more bytes.
  void cut_after(std::size_t bytes) { left_ = bytes; }
  std::vector<std::byte>& medium() { return medium_; }
  std::byte* record(std::size_t copy, std::size_t slot) { return medium_.data() + copy * kCopy + slot * kRecord; }

  std::size_t size() const override { return medium_.size(); }
  Status read(std::size_t offset, std::span<std::byte> bytes) override {
    if (offset + bytes.size() > medium_.size()) return fail(ErrorCode::kCannotRead, "past the end");
    std::copy_n(medium_.begin() + static_cast<std::ptrdiff_t>(offset), bytes.size(), bytes.begin());
    return {};
  }
  Status write(std::size_t offset, std::span<const std::byte> bytes) override {
    if (drops) return {};
    const std::size_t arrived = std::min(bytes.size(), left_);
    std::copy_n(bytes.begin(), arrived, medium_.begin() + static_cast<std::ptrdiff_t>(offset));
    left_ -= arrived;
    if (arrived < bytes.size()) return fail(ErrorCode::kCannotWrite, "cut");
    return {};
  }
  Status sync() override {
    ++syncs;
    if (left_ == 0) return fail(ErrorCode::kCannotWrite, "cut");
    return {};
  }

  int syncs = 0;
  bool drops = false;  ///< writes, without a word

 private:
  std::vector<std::byte> medium_;
  std::size_t left_ = std::size_t{1} << 30U;  ///< bytes until the cut; by default more than a test writes
};

constexpr std::uint64_t kJob = 0x1234'5678'9ABC'DEF0U;

JournalEntry after(std::uint32_t layers) {
  return {.next_layer = layers,
          .height = ZPosition(50_um * layers),
          .stands = ZPosition(50_um * layers + 1_um),
          .cured_pixels = 1000U * layers,
          .elapsed = 10s * layers,
          .lit = 1ms * layers};
}

/// A journal with `cured` layers.
CutStorage storage_with(std::uint32_t cured, std::uint64_t job = kJob) {
  CutStorage storage;
  auto journal = Journal::create(storage, job, kLayers).value();
  for (std::uint32_t layer = 1; layer <= cured; ++layer) EXPECT_TRUE(journal.append(after(layer)));
  return storage;
}

/// Opens what is left of a journal of `cured` layers, which must have its last layer or be refused in words.
/// @returns whether it was refused
bool right_or_refused(CutStorage& storage, std::uint32_t cured) {
  const auto journal = Journal::open(storage);
  if (journal) {
    if (journal->job_hash() != kJob) return true;  // PrintSession::load() refuses it
    EXPECT_EQ(journal->last(), cured == 0 ? JournalEntry() : after(cured));
    return false;
  }
  EXPECT_THAT(journal.error().code(),
              AnyOf(ErrorCode::kMalformed, ErrorCode::kTruncated, ErrorCode::kUnsupported, ErrorCode::kCannotRead));
  EXPECT_GT(std::strlen(journal.error().message()), 10U);
  return true;
}

TEST(Journal, KnowsTheLastCuredLayer) {
  for (const std::uint32_t cured : {0U, 1U, 7U, 20U}) {
    auto storage = storage_with(cured);
    const auto journal = Journal::open(storage);
    ASSERT_TRUE(journal) << journal.error().message();
    EXPECT_EQ(journal->last(), cured == 0 ? JournalEntry() : after(cured));
    EXPECT_EQ(journal->job_hash(), kJob);
    EXPECT_EQ(journal->layers(), kLayers);
  }
}

TEST(Journal, IsDurableTwiceAfterEveryLayer) {
  const auto storage = storage_with(7);
  EXPECT_EQ(storage.syncs, 1 + 2 * 7) << "when it is created, and for each copy of an entry";
}

TEST(Journal, AppendsAfterReopening) {
  auto storage = storage_with(3);
  auto journal = Journal::open(storage);
  ASSERT_TRUE(journal);
  EXPECT_TRUE(journal->append(after(3))) << "the print resumes";
  EXPECT_TRUE(journal->append(after(4)));
  EXPECT_EQ(Journal::open(storage)->last(), after(4));
}

TEST(Journal, CutAtAnyByteOfEitherCopyKeepsTheEntryWholeOrNotAtAllAndGoesOn) {
  std::mt19937_64 random(3);
  for (std::size_t bytes = 0; bytes <= 2 * kRecord; ++bytes) {
    for (const bool garbage : {false, true}) {
      auto storage = storage_with(5);
      auto journal = Journal::open(storage).value();
      storage.cut_after(bytes);
      EXPECT_FALSE(journal.append(after(6))) << "sync() has no power either";
      EXPECT_FALSE(journal.append(after(6))) << "nothing is written after a failure";
      CutStorage later(storage.medium());
      if (garbage && bytes % kRecord != 0) {  // the rest of what was being written is neither old nor new
        std::byte* const torn = later.record(bytes / kRecord, 6);
        std::generate(torn + bytes % kRecord, torn + kRecord, [&] { return static_cast<std::byte>(random()); });
      }
      auto again = Journal::open(later);
      ASSERT_TRUE(again) << bytes << " bytes: " << again.error().message();
      // A record and a seal begin differently and may end alike.
      const std::uint32_t cured = again->last().next_layer;
      ASSERT_TRUE(bytes < kRecord ? cured == 5 : cured == 6) << bytes;
      EXPECT_EQ(again->last(), after(cured));
      for (std::uint32_t layer = cured + 1; layer <= 8; ++layer) ASSERT_TRUE(again->append(after(layer)));
      EXPECT_EQ(Journal::open(later)->last(), after(8)) << bytes;
    }
  }
}

TEST(Journal, CutAgainAtAnyByteOfItsNextAppendStillKeepsTheEntryWholeOrNotAtAll) {
  for (std::size_t first = 0; first <= 2 * kRecord; first += 13) {
    for (std::size_t second = 0; second <= 3 * kRecord; ++second) {
      auto storage = storage_with(5);
      auto journal = Journal::open(storage).value();
      storage.cut_after(first);
      EXPECT_FALSE(journal.append(after(6)));
      CutStorage later(storage.medium());
      auto again = Journal::open(later).value();
      const std::uint32_t cured = again.last().next_layer;
      later.cut_after(second);
      static_cast<void>(again.append(after(cured + 1)));
      CutStorage last(later.medium());
      const auto found = Journal::open(last);
      ASSERT_TRUE(found) << first << ", then " << second << " bytes: " << found.error().message();
      ASSERT_THAT(found->last(), AnyOf(after(cured), after(cured + 1))) << first << ", then " << second << " bytes";
    }
  }
}

TEST(Journal, CutWhileItIsCreatedIsNeverTakenForAJournal) {
  for (std::size_t bytes = 0; bytes < Journal::bytes_needed(kLayers); bytes += 61) {
    CutStorage storage;
    storage.cut_after(bytes);
    EXPECT_FALSE(Journal::create(storage, kJob, kLayers));
    EXPECT_TRUE(right_or_refused(storage, 0)) << bytes;
  }
  CutStorage blank;
  EXPECT_EQ(Journal::open(blank).error().code(), ErrorCode::kTruncated);
}

TEST(Journal, NoticesEveryFlippedBitOrReadsTheOtherCopy) {
  const auto whole = storage_with(4).medium();
  for (std::size_t byte = 0; byte < 6 * kRecord; ++byte) {
    for (unsigned bit = 0; bit < 8; ++bit) {
      CutStorage storage(whole);
      storage.medium()[byte] ^= std::byte{1} << bit;
      right_or_refused(storage, 4);
      storage.medium()[kCopy + byte] ^= std::byte{1} << bit;
      ASSERT_TRUE(right_or_refused(storage, 4)) << "byte " << byte << " bit " << bit << " of both went unnoticed";
    }
  }
}

TEST(Journal, SaysWhichRecordIsDamaged) {
  auto storage = storage_with(4);
  for (const std::size_t copy : {0U, 1U}) storage.record(copy, 3)[20] ^= std::byte{1};
  EXPECT_THAT(Journal::open(storage).error().message(), HasSubstr("damaged at record 3"));
}

/// Lost: zero, garbage, or as if it had never been written.
TEST(Journal, NoticesThatEitherCopyHasLostItsEnd) {
  constexpr std::uint32_t kCured = 15;
  const auto blank = storage_with(0).medium();
  for (const std::size_t copy : {0U, 1U}) {
    for (std::uint32_t lost = 1; lost <= kCured; ++lost) {
      for (const int how : {0, 1, 2}) {
        auto storage = storage_with(kCured);
        std::byte* const from = storage.record(copy, kCured + 1 - lost);
        if (how == 0) std::fill_n(from, lost * kRecord, std::byte{0});
        if (how == 1) std::fill_n(from, lost * kRecord, std::byte{0xFF});
        if (how == 2) std::copy_n(blank.data() + (from - storage.medium().data()), lost * kRecord, from);
        // The second copy may be one behind, since the first is written before it.
        EXPECT_EQ(right_or_refused(storage, kCured), copy == 0 || lost > 1) << copy << ' ' << lost << ' ' << how;
      }
    }
  }
}

TEST(Journal, NoticesZerosFromAnywhereToAnywhere) {
  const auto whole = storage_with(15).medium();
  for (std::size_t from = 0; from < whole.size(); from += 509) {
    for (std::size_t to = from + 64; to <= whole.size(); to += 1021) {
      CutStorage storage(whole);
      std::fill(storage.medium().begin() + static_cast<std::ptrdiff_t>(from),
                storage.medium().begin() + static_cast<std::ptrdiff_t>(to), std::byte{0});
      right_or_refused(storage, 15);
      if (HasFailure()) FAIL() << from << " to " << to;
    }
  }
}

TEST(Journal, NoticesLostSwappedAndForeignRecords) {
  auto lost = storage_with(4);
  for (const std::size_t copy : {0U, 1U}) std::fill_n(lost.record(copy, 2), kRecord, std::byte{0});
  EXPECT_EQ(Journal::open(lost).error().code(), ErrorCode::kMalformed);

  auto swapped = storage_with(4);
  for (const std::size_t copy : {0U, 1U}) {
    std::swap_ranges(swapped.record(copy, 2), swapped.record(copy, 3), swapped.record(copy, 3));
  }
  EXPECT_EQ(Journal::open(swapped).error().code(), ErrorCode::kMalformed);

  auto behind = storage_with(4);
  behind.record(1, 9)[3] = std::byte{7};
  EXPECT_EQ(Journal::open(behind).error().code(), ErrorCode::kMalformed);

  auto shorter = storage_with(4);
  shorter.medium().resize(3 * kRecord);
  EXPECT_EQ(Journal::open(shorter).error().code(), ErrorCode::kMalformed);

  auto other = storage_with(4);
  auto another = storage_with(4, kJob + 1);
  for (const std::size_t copy : {0U, 1U}) std::copy_n(another.record(copy, 4), kRecord, other.record(copy, 4));
  EXPECT_EQ(Journal::open(other).error().code(), ErrorCode::kMalformed) << "a record of another print";
}

TEST(Journal, AfterAnyOf10000DamagesHasTheRightLayerOrIsRefused) {
  std::mt19937_64 random(2025);
  const auto below = [&random](std::size_t end) { return static_cast<std::size_t>(random() % end); };
  const auto foreign = storage_with(kLayers, kJob + 1).medium();
  const auto empty = storage_with(0).medium();
  int refused = 0;
  for (int round = 0; round < 10'000; ++round) {
    const auto cured = static_cast<std::uint32_t>(1 + below(kLayers));
    CutStorage storage = storage_with(cured);
    auto& medium = storage.medium();
    const auto undamaged = medium;
    const std::size_t forgetful = below(2);
    for (std::size_t damages = 1 + below(3); damages > 0; --damages) {
      // Half of them where the records are.
      const std::size_t from = below(2) == 0 ? below(medium.size()) : below(2) * kCopy + below((cured + 2) * kRecord);
      const std::size_t count = std::min(medium.size() - from, 1 + below(std::size_t{1} << (3 + below(15))));
      const auto place = medium.begin() + static_cast<std::ptrdiff_t>(from);
      switch (below(7)) {
        case 0: medium[from] ^= std::byte{1} << below(8); break;
        case 1: std::fill_n(place, count, std::byte{0}); break;
        case 2: std::fill_n(place, count, std::byte{0xFF}); break;
        case 3: std::generate_n(place, count, [&] { return static_cast<std::byte>(random()); }); break;
        case 4: std::copy_n(foreign.begin() + static_cast<std::ptrdiff_t>(from), count, place); break;
        case 5: {  // a block of the file in another place
          const auto source = std::vector<std::byte>(place, place + static_cast<std::ptrdiff_t>(count));
          std::copy_n(source.begin(), count,
                      medium.begin() + static_cast<std::ptrdiff_t>(below(medium.size() - count + 1)));
          break;
        }
        default: {  // as if one copy had never been written from there on
          const std::size_t slot = below(cured + 2);
          std::copy_n(empty.data() + forgetful * kCopy + slot * kRecord, kCopy - slot * kRecord,
                      storage.record(forgetful, slot));
        }
      }
    }
    if (below(20) == 0) medium.resize(below(medium.size()));
    // The last record spoiled in the first copy and never written to the second: the power was cut in its write.
    const bool whole = medium.size() >= 2 * kCopy;
    const auto is = [&](std::size_t copy, const std::vector<std::byte>& as) {
      const std::size_t at = copy * kCopy + cured * kRecord;
      return std::memcmp(medium.data() + at, as.data() + at, kRecord) == 0;
    };
    const bool cut = whole && !is(0, undamaged) && !is(0, empty) && is(1, empty);
    refused += right_or_refused(storage, cut && Journal::open(storage) ? cured - 1 : cured) ? 1 : 0;
    if (HasFailure()) FAIL() << "round " << round;
  }
  EXPECT_GT(refused, 3000);
  EXPECT_LT(refused, 9500);
}

TEST(Journal, NoticesAMediumThatTakesWritesAndDropsThem) {
  auto storage = storage_with(5);
  auto journal = Journal::open(storage).value();
  storage.drops = true;
  const auto appended = journal.append(after(6));
  ASSERT_FALSE(appended);
  EXPECT_EQ(appended.error().code(), ErrorCode::kCannotWrite);
  EXPECT_THAT(appended.error().message(), HasSubstr("did not keep"));
}

/// A record as on the medium, with a right hash.
std::array<std::uint64_t, 8> record_of(std::uint32_t next_layer, std::uint32_t slot) {
  std::array<std::uint64_t, 8> record = {next_layer | std::uint64_t{slot} << 32U, kJob};
  Hash64 hash;
  hash.add(std::as_bytes(std::span(record)).first(56));
  record[7] = hash.value();
  return record;
}

TEST(Journal, IsNotBelievedWhenItSkipsALayerOrHasMoreThanThePrint) {
  const auto opened_with = [](std::uint32_t next_layer) {
    auto storage = storage_with(5);
    const auto record = record_of(next_layer, 6);
    for (const std::size_t copy : {0U, 1U}) std::memcpy(storage.record(copy, 6), record.data(), sizeof record);
    auto journal = Journal::open(storage);
    if (journal) {
      EXPECT_EQ(journal->last().next_layer, next_layer);
    }
    return journal.has_value() ? std::string() : std::string(journal.error().message());
  };
  EXPECT_EQ(opened_with(5), "") << "an interruption";
  EXPECT_EQ(opened_with(6), "");
  for (const std::uint32_t wrong : {7U, 4U, 0U, 20U, 21U, 0xFFFF'FFFEU}) {
    EXPECT_THAT(opened_with(wrong), HasSubstr("damaged at record 6: it skips a layer")) << wrong;
  }
}

/// "PLJ1", 20 layers, job 7, as version 0.1 wrote it.
TEST(Journal, RefusesTheFormatBeforeInWords) {
  std::array<std::uint64_t, 8> header = {0x14'314A'4C50U, 7};
  Hash64 hash;
  hash.add(std::as_bytes(std::span(header)).first(56));
  header[7] = hash.value();
  CutStorage storage(std::vector<std::byte>(kRecord * (1 + kLayers + 1024)));
  std::memcpy(storage.medium().data(), header.data(), sizeof header);
  const auto journal = Journal::open(storage);
  ASSERT_FALSE(journal);
  EXPECT_EQ(journal.error().code(), ErrorCode::kUnsupported);
  EXPECT_THAT(journal.error().message(), HasSubstr("older version"));
}

TEST(Journal, KeepsRoomForEachLayerToCome) {
  CutStorage storage;
  auto journal = Journal::create(storage, kJob, kLayers).value();
  while (journal.has_spare()) ASSERT_TRUE(journal.append(after(0)));
  for (std::uint32_t layer = 1; layer <= kLayers; ++layer) ASSERT_TRUE(journal.append(after(layer)));
  EXPECT_FALSE(journal.append(after(kLayers)));
}

TEST(Journal, RefusesAnEntryWhenFull) {
  CutStorage storage(1);
  auto journal = Journal::create(storage, kJob, 1).value();
  ASSERT_TRUE(journal.append(after(1)));
  for (std::size_t i = 0; i < Journal::kSpareRecords; ++i) ASSERT_TRUE(journal.append(after(1)));
  while (journal.has_spare()) ASSERT_TRUE(journal.append(after(1)));  // until the end of the page
  EXPECT_EQ(journal.append(after(1)).error().code(), ErrorCode::kCannotWrite);
  EXPECT_EQ(Journal::open(storage)->last(), after(1));
}

TEST(Hash64, IsTheSameHoweverTheBytesAreSplit) {
  std::vector<std::byte> bytes(100);
  for (std::size_t i = 0; i < bytes.size(); ++i) bytes[i] = static_cast<std::byte>(i * 37 + 1);
  Hash64 whole;
  whole.add(bytes);
  for (std::size_t cut = 0; cut <= bytes.size(); ++cut) {
    Hash64 parts;
    parts.add(std::span(bytes).first(cut));
    parts.add(std::span(bytes).subspan(cut));
    EXPECT_EQ(parts.value(), whole.value()) << cut;
  }
}

TEST(Hash64, CountsZerosAtTheEnd) {
  const std::vector<std::byte> zeros(9);
  std::vector<std::uint64_t> values;
  for (std::size_t size = 0; size <= zeros.size(); ++size) {
    Hash64 hash;
    hash.add(std::span(zeros).first(size));
    values.push_back(hash.value());
  }
  std::sort(values.begin(), values.end());
  EXPECT_EQ(std::adjacent_find(values.begin(), values.end()), values.end());
}

}  // namespace journal_test
}  // namespace plumbline::firmware
