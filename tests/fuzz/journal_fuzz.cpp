/// A damaged journal has the right layer or is refused; records with right hashes and any content never break the reader.

#include <cstdint>
#include <cstring>
#include <span>
#include <vector>

#include "firmware/io/hash64.hpp"
#include "firmware/print/job/journal.hpp"
#include "tests/fuzz/edits.hpp"
#include "tests/fuzz/require.hpp"

namespace plumbline::firmware::fuzz {
namespace {

constexpr std::uint32_t kLayers = 20;
constexpr std::uint32_t kCured = 9;
constexpr std::size_t kRecord = Journal::kRecordBytes;
constexpr std::uint64_t kJob = 7;

class Medium final : public JournalStorage {
 public:
  std::size_t size() const override { return bytes.size(); }
  Status read(std::size_t offset, std::span<std::byte> to) override {
    require(offset + to.size() <= bytes.size(), "a read past the end");
    std::memcpy(to.data(), bytes.data() + offset, to.size());
    return {};
  }
  Status write(std::size_t offset, std::span<const std::byte> from) override {
    require(offset + from.size() <= bytes.size(), "a write past the end");
    std::memcpy(bytes.data() + offset, from.data(), from.size());
    return {};
  }
  Status sync() override { return {}; }

  std::vector<std::byte> bytes = std::vector<std::byte>(Journal::bytes_needed(kLayers));
};

JournalEntry after(std::uint32_t layers) {
  return {.next_layer = layers,
          .height = ZPosition(Distance::micrometres(50.0 * layers)),
          .stands = ZPosition(Distance::micrometres(50.0 * layers)),
          .cured_pixels = 100U * layers};
}

const Medium& whole() {
  static const Medium made = [] {
    Medium medium;
    auto journal = Journal::create(medium, kJob, kLayers).value();
    for (std::uint32_t layer = 1; layer <= kCured; ++layer) require(journal.append(after(layer)).has_value(), "append");
    return medium;
  }();
  return made;
}

void check_damaged(Input& input) {
  Medium medium = whole();
  while (!input.empty()) damage(medium.bytes, input);
  const auto journal = Journal::open(medium);
  if (journal) {
    require(journal->last() == after(kCured), "another layer than the right one");
    return;
  }
  require(std::strlen(journal.error().message()) > 10, "an error without a message");
}

/// Records of the input, in any slots, with their hashes made right.
void check_sealed(Input& input) {
  Medium medium = whole();
  const std::size_t slots = Journal::copy_bytes(kLayers) / kRecord;
  while (!input.empty()) {
    const std::size_t slot = input.take<std::uint8_t>() % 16 == 15 ? input.below(slots) : input.below(12);
    std::uint64_t record[kRecord / 8] = {};
    for (auto& word : std::span(record).first(7)) word = input.take<std::uint8_t>();
    record[0] |= std::uint64_t{slot} << 32U;  // its slot and job, so that it is read at all
    if (input.take<std::uint8_t>() % 8 != 0) record[1] = kJob;
    Hash64 hash;
    hash.add(std::as_bytes(std::span(record)).first(kRecord - 8));
    record[7] = hash.value();
    const auto copies = input.take<std::uint8_t>();
    for (const std::size_t copy : {0U, 1U}) {
      if ((copies >> copy) % 2 == 0) {
        std::memcpy(medium.bytes.data() + copy * Journal::copy_bytes(kLayers) + slot * kRecord, record, kRecord);
      }
    }
  }
  auto journal = Journal::open(medium);
  if (!journal) return;
  require(journal->last().next_layer <= journal->layers(), "a layer that the print does not have");
  if (journal->last().next_layer == journal->layers()) return;
  JournalEntry next = journal->last();
  ++next.next_layer;
  if (!journal->append(next)) return;
  const auto again = Journal::open(medium);
  require(again.has_value() && again->last() == next, "what was appended is not read again");
}

void check_any(std::span<const std::uint8_t> bytes) {
  Medium medium;
  const auto any = std::as_bytes(bytes);
  medium.bytes.assign(any.begin(), any.end());
  require(!Journal::open(medium), "any bytes are a journal");
}

}  // namespace
}  // namespace plumbline::firmware::fuzz

extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* bytes, std::size_t size) {
  using namespace plumbline::firmware::fuzz;
  const std::span all(bytes, size);
  if (all.empty()) return 0;
  Input input(all.subspan(1));
  switch (all[0] % 4) {
    case 0:
    case 1: check_damaged(input); break;
    case 2: check_sealed(input); break;
    default: check_any(all.subspan(1)); break;
  }
  return 0;
}
