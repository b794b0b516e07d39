#pragma once
/// The journal of a print: what has been cured, durable layer by layer, so that a print can resume after a power cut.
///
/// It has two copies, which share no sector of the medium. A copy is a header and slots for records, all of 64 bytes that end with
/// a hash of those before. A slot without a record holds a seal, so that no slot may be zero: lost bytes are never taken for
/// slots that were not written yet. A record goes to the first copy, and when it is durable there, to the second one. So a power
/// cut can spoil the last record of one copy and nothing else:
///
///     copy 1    header | record 1 | ... | record n | seal or spoiled | seal | ...
///     copy 2    header | record 1 | ... | record n | seal            | seal | ...        or one record behind copy 1
///
/// Other states are damage. A record that is damaged in one copy is read from the other, but each copy must have the end. If it has
/// not, the journal is refused, since a print that resumes below its last layer presses the part into the film.

#include <cstddef>
#include <cstdint>
#include <span>

#include "hal/clock.hpp"
#include "hal/units.hpp"
#include "slicer/core/error.hpp"

namespace plumbline::firmware {

/// The medium of a journal. An interface, so that a test can cut the power inside a write.
class JournalStorage {
 public:
  virtual ~JournalStorage() = default;

  /// @returns bytes
  virtual std::size_t size() const = 0;
  /// @retval ErrorCode::kCannotRead
  [[nodiscard]] virtual Status read(std::size_t offset, std::span<std::byte> bytes) = 0;
  /// Durable only after sync().
  /// @retval ErrorCode::kCannotWrite
  [[nodiscard]] virtual Status write(std::size_t offset, std::span<const std::byte> bytes) = 0;
  /// Makes all writes durable. A read that follows asks the medium, not a copy of it in memory.
  /// @retval ErrorCode::kCannotWrite
  [[nodiscard]] virtual Status sync() = 0;
};

/// How far a print has come.
struct JournalEntry {
  std::uint32_t next_layer = 0;    ///< all layers before it are cured
  ZPosition height;                ///< of the last cured layer; 0 before the first
  ZPosition stands;                ///< where the plate stood when this was written
  std::uint64_t cured_pixels = 0;  ///< of all cured layers
  /// Of next_layer's mask: after a power cut nobody knows whether it has been lit. 0: not known yet, or all are cured.
  std::uint32_t at_hand_pixels = 0;
  nanoseconds elapsed{};  ///< printing time, over all runs; whole milliseconds are kept, up to 49 days
  nanoseconds
      lit{};  ///< light that next_layer has had already, if the print was stopped during it; whole microseconds are kept
  nanoseconds lamp{};  ///< light of all layers, over all runs; whole milliseconds are kept
  bool operator==(const JournalEntry&) const = default;
};

class Journal {
 public:
  static constexpr std::size_t kRecordBytes = 64;
  /// Room beyond one record a layer, for pauses and interruptions. See has_spare().
  static constexpr std::size_t kSpareRecords = 256;
  /// A copy fills whole pages of this size, so that a write to one copy never touches the other.
  static constexpr std::size_t kPageBytes = 4096;

  /// @returns bytes of one copy
  static constexpr std::size_t copy_bytes(std::uint32_t layers) {
    const std::size_t bytes = kRecordBytes * (1 + std::size_t{layers} + kSpareRecords);
    return (bytes + kPageBytes - 1) / kPageBytes * kPageBytes;
  }
  /// @returns bytes of storage
  static constexpr std::size_t bytes_needed(std::uint32_t layers) { return 2 * copy_bytes(layers); }

  /// Writes the seals and headers of a new print.
  /// @param storage   bytes_needed(layers) or more, or grows when it is written to; outlives the journal
  /// @param job_hash  of the job that the entries are about (JobStore). No other print may have the same
  /// @retval ErrorCode::kCannotWrite
  [[nodiscard]] static Expected<Journal> create(JournalStorage& storage, std::uint64_t job_hash, std::uint32_t layers);

  /// Reads the journal of an interrupted print.
  /// @retval ErrorCode::kTruncated    there is none: the storage is empty
  /// @retval ErrorCode::kUnsupported  another version of plumbline wrote it
  /// @retval ErrorCode::kMalformed    damaged, and where: the print must not resume
  /// @retval ErrorCode::kCannotRead
  [[nodiscard]] static Expected<Journal> open(JournalStorage& storage);

  std::uint64_t job_hash() const { return job_hash_; }
  std::uint32_t layers() const { return layers_; }
  /// The last entry; a default one before the first layer.
  const JournalEntry& last() const { return last_; }

  /// Whether there is room for a record beyond one for each layer to come.
  bool has_spare() const { return records_ + (layers_ - last_.next_layer) + 1 < slots(); }

  /// Durable in both copies when it returns. Takes nothing from the heap.
  /// @param entry  next_layer is that of the last entry or one more
  /// @retval ErrorCode::kCannotWrite  also if the journal is full, the medium has not kept what it was given, or
  ///         an earlier append() has failed
  [[nodiscard]] Status append(const JournalEntry& entry);

 private:
  Journal(JournalStorage& storage, std::uint64_t job_hash, std::uint32_t layers)
      : storage_(&storage), job_hash_(job_hash), layers_(layers) {}

  [[nodiscard]] Status read_records();
  /// Durable and read back when it returns.
  [[nodiscard]] Status store(std::size_t copy, std::size_t slot, const JournalEntry& entry);
  std::size_t slots() const { return copy_bytes(layers_) / kRecordBytes; }
  std::size_t place_of(std::size_t copy, std::size_t slot) const {
    return copy * copy_bytes(layers_) + slot * kRecordBytes;
  }

  JournalStorage* storage_;
  std::uint64_t job_hash_ = 0;
  std::uint32_t layers_ = 0;
  JournalEntry last_;
  std::size_t records_ = 0;     ///< written
  bool second_behind_ = false;  ///< the second copy lacks the last record
  bool failed_ = false;         ///< append() has failed
};

}  // namespace plumbline::firmware
