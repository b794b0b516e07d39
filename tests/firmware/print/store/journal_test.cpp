#include "firmware/print/store/journal.hpp"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <algorithm>
#include <vector>

#include "firmware/io/hash64.hpp"

namespace plumbline {
namespace {

using namespace plumbline::literals;
using namespace std::chrono_literals;
using ::testing::HasSubstr;

/// A medium whose power fails: it keeps the first bytes of a write and none of the later writes.
class CutStorage final : public JournalStorage {
 public:
  explicit CutStorage(std::uint32_t layers) : medium_(Journal::bytes_needed(layers)) {}
  explicit CutStorage(std::vector<std::byte> medium) : medium_(std::move(medium)) {}

  /// Stops writing after `bytes` more bytes.
  void cut_after(std::size_t bytes) { left_ = bytes; }
  std::vector<std::byte>& medium() { return medium_; }

  std::size_t size() const override { return medium_.size(); }
  Status read(std::size_t offset, std::span<std::byte> bytes) override {
    std::copy_n(medium_.begin() + static_cast<std::ptrdiff_t>(offset), bytes.size(), bytes.begin());
    return {};
  }
  Status write(std::size_t offset, std::span<const std::byte> bytes) override {
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

 private:
  std::vector<std::byte> medium_;
  std::size_t left_ = std::size_t{1} << 30U;  ///< bytes until the cut; by default more than a test writes
};

constexpr std::uint64_t kJob = 0x1234'5678'9ABC'DEF0U;

JournalEntry after(std::uint32_t layers) {
  return {.next_layer = layers,
          .height = ZPosition(50_um * layers),
          .cured_pixels = 1000U * layers,
          .elapsed = 10s * layers,
          .lit = 1ms * layers};
}

/// A journal with `cured` layers.
CutStorage storage_with(std::uint32_t cured) {
  CutStorage storage(20);
  auto journal = Journal::create(storage, kJob, 20).value();
  for (std::uint32_t layer = 1; layer <= cured; ++layer) EXPECT_TRUE(journal.append(after(layer)));
  return storage;
}

TEST(Journal, KnowsTheLastCuredLayer) {
  for (const std::uint32_t cured : {0U, 1U, 7U, 20U}) {
    auto storage = storage_with(cured);
    const auto journal = Journal::open(storage);
    ASSERT_TRUE(journal) << journal.error().message();
    EXPECT_EQ(journal->last(), cured == 0 ? JournalEntry() : after(cured));
    EXPECT_EQ(journal->job_hash(), kJob);
    EXPECT_EQ(journal->layers(), 20U);
    EXPECT_FALSE(journal->cut_short());
  }
}

TEST(Journal, IsDurableAfterEveryLayer) {
  const auto storage = storage_with(7);
  EXPECT_EQ(storage.syncs, 8) << "the header and each entry";
}

TEST(Journal, AppendsAfterReopening) {
  auto storage = storage_with(3);
  auto journal = Journal::open(storage);
  ASSERT_TRUE(journal);
  EXPECT_TRUE(journal->append(after(3))) << "the print resumes";
  EXPECT_TRUE(journal->append(after(4)));
  EXPECT_EQ(Journal::open(storage)->last(), after(4));
}

TEST(Journal, CutAtAnyByteKeepsTheEntryWholeOrNotAtAll) {
  for (std::size_t bytes = 0; bytes <= Journal::kRecordBytes; ++bytes) {
    auto storage = storage_with(5);
    auto journal = Journal::open(storage).value();
    storage.cut_after(bytes);
    EXPECT_EQ(journal.append(after(6)).has_value(), false) << "sync() has no power either";
    const auto again = Journal::open(storage);
    ASSERT_TRUE(again) << bytes << " bytes: " << again.error().message();
    EXPECT_EQ(again->last(), bytes == Journal::kRecordBytes ? after(6) : after(5)) << bytes;
  }
}

TEST(Journal, OverwritesAnEntryThatWasCutShort) {
  for (std::size_t bytes = 1; bytes < Journal::kRecordBytes; ++bytes) {
    auto storage = storage_with(5);
    auto journal = Journal::open(storage).value();
    storage.cut_after(bytes);
    static_cast<void>(journal.append(after(6)));
    CutStorage repaired(storage.medium());
    auto again = Journal::open(repaired).value();
    ASSERT_TRUE(again.append(after(6)));
    EXPECT_EQ(Journal::open(repaired)->last(), after(6)) << bytes;
  }
}

TEST(Journal, CutInItsHeaderCountsAsMissing) {
  for (std::size_t bytes = 0; bytes < Journal::kRecordBytes; ++bytes) {
    CutStorage storage(20);
    storage.cut_after(bytes);
    EXPECT_FALSE(Journal::create(storage, kJob, 20));
    const auto journal = Journal::open(storage);
    ASSERT_FALSE(journal);
    EXPECT_EQ(journal.error().code(), ErrorCode::kTruncated) << bytes;
  }
}

TEST(Journal, NoticesEveryFlippedBit) {
  const auto whole = storage_with(4).medium();
  int flips = 0;
  for (std::size_t byte = 0; byte < 5 * Journal::kRecordBytes; ++byte) {
    for (unsigned bit = 0; bit < 8; ++bit) {
      CutStorage storage(whole);
      storage.medium()[byte] ^= std::byte{1} << bit;
      const auto journal = Journal::open(storage);
      ASSERT_FALSE(journal) << "byte " << byte << " bit " << bit << " went unnoticed";
      EXPECT_EQ(journal.error().code(), ErrorCode::kMalformed);
      ++flips;
    }
  }
  EXPECT_EQ(flips, 5 * 64 * 8);
}

TEST(Journal, SaysWhichRecordIsDamaged) {
  auto storage = storage_with(4);
  storage.medium()[3 * Journal::kRecordBytes + 20] ^= std::byte{1};
  EXPECT_THAT(Journal::open(storage).error().message(), HasSubstr("damaged at record 3"));
}

TEST(Journal, NoticesBytesPastItsEndAndLostOrForeignRecords) {
  auto behind = storage_with(4);
  behind.medium()[9 * Journal::kRecordBytes + 3] = std::byte{7};
  EXPECT_EQ(Journal::open(behind).error().code(), ErrorCode::kMalformed);

  auto lost = storage_with(4);
  std::fill_n(lost.medium().begin() + 2 * Journal::kRecordBytes, Journal::kRecordBytes, std::byte{0});
  EXPECT_EQ(Journal::open(lost).error().code(), ErrorCode::kMalformed);

  auto swapped = storage_with(4);
  std::swap_ranges(swapped.medium().begin() + 2 * Journal::kRecordBytes,
                   swapped.medium().begin() + 3 * Journal::kRecordBytes,
                   swapped.medium().begin() + 3 * Journal::kRecordBytes);
  EXPECT_EQ(Journal::open(swapped).error().code(), ErrorCode::kMalformed);

  auto shorter = storage_with(4);
  shorter.medium().resize(3 * Journal::kRecordBytes);
  EXPECT_EQ(Journal::open(shorter).error().code(), ErrorCode::kMalformed);

  auto other = storage_with(4);
  const auto another = [] {
    CutStorage storage(20);
    auto journal = Journal::create(storage, kJob + 1, 20).value();
    for (std::uint32_t layer = 1; layer <= 4; ++layer) EXPECT_TRUE(journal.append(after(layer)));
    return storage.medium();
  }();
  std::copy_n(another.begin() + 4 * Journal::kRecordBytes, Journal::kRecordBytes,
              other.medium().begin() + 4 * Journal::kRecordBytes);
  EXPECT_EQ(Journal::open(other).error().code(), ErrorCode::kMalformed) << "a record of another print";
}

TEST(Journal, RefusesAnEntryWhenFull) {
  CutStorage storage(1);
  auto journal = Journal::create(storage, kJob, 1).value();
  ASSERT_TRUE(journal.append(after(1)));
  for (std::size_t i = 0; i < Journal::kSpareRecords; ++i) ASSERT_TRUE(journal.append(after(1)));
  EXPECT_EQ(journal.append(after(1)).error().code(), ErrorCode::kCannotWrite);
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

}  // namespace
}  // namespace plumbline
