#pragma once
/// The journal of a print: what has been cured, durable layer by layer, so that a print goes on after the power has failed.
///
/// A header and then one record after the other, each 64 bytes that end with a hash of those before. The file is as large
/// as it will ever be and full of zeros when a print begins, so a record that the power cut in half ends in zeros. That
/// one is as if it had never been written. Anything else that does not add up is damage, and damage is never followed.

#include <cstddef>
#include <cstdint>
#include <optional>
#include <span>

#include "hal/clock.hpp"
#include "hal/units.hpp"
#include "slicer/core/error.hpp"

namespace plumbline {

/// Where a journal's bytes are. Small, so that a test can cut the power inside a write.
class JournalStorage {
 public:
  virtual ~JournalStorage() = default;

  /// Bytes that the storage has.
  virtual std::size_t size() const = 0;
  /// @retval ErrorCode::kCannotRead
  [[nodiscard]] virtual Status read(std::size_t offset, std::span<std::byte> bytes) = 0;
  /// Need not be durable.
  /// @retval ErrorCode::kCannotWrite
  [[nodiscard]] virtual Status write(std::size_t offset, std::span<const std::byte> bytes) = 0;
  /// All that was written is durable when this returns.
  /// @retval ErrorCode::kCannotWrite
  [[nodiscard]] virtual Status sync() = 0;
};

/// What a print has come to.
struct JournalEntry {
  std::uint32_t next_layer = 0;    ///< all layers before it are cured
  ZPosition height;                ///< of the last cured layer; 0 before the first
  std::uint64_t cured_pixels = 0;  ///< of all cured layers
  nanoseconds elapsed{};           ///< printing, over all its parts
  nanoseconds lit{};               ///< light that next_layer has had, where the print was stopped within it in order
  bool operator==(const JournalEntry&) const = default;
};

class Journal {
 public:
  static constexpr std::size_t kRecordBytes = 64;
  /// Records beyond one for each layer: one for each time that the print goes on.
  static constexpr std::size_t kSpareRecords = 1024;

  /// Bytes of storage for a print.
  static constexpr std::size_t bytes_needed(std::uint32_t layers) {
    return kRecordBytes * (1 + std::size_t{layers} + kSpareRecords);
  }

  /// Writes the header of a new print.
  /// @param storage   all zeros, bytes_needed(layers) or more; outlives the journal
  /// @param job_hash  of the job that the entries are about (JobStore)
  /// @retval ErrorCode::kCannotWrite
  [[nodiscard]] static Expected<Journal> create(JournalStorage& storage, std::uint64_t job_hash, std::uint32_t layers);

  /// Reads the journal of a print that was interrupted.
  /// @retval ErrorCode::kTruncated  there is none: it was cut off while it was being created, and no layer was printed
  /// @retval ErrorCode::kMalformed  damaged: at which record. It must not be followed
  /// @retval ErrorCode::kCannotRead
  [[nodiscard]] static Expected<Journal> open(JournalStorage& storage);

  std::uint64_t job_hash() const { return job_hash_; }
  std::uint32_t layers() const { return layers_; }
  /// The last entry; that of a print which has not cured a layer yet where there is none.
  const JournalEntry& last() const { return last_; }
  /// open() found a record that the power cut in half.
  bool cut_short() const { return cut_short_; }

  /// Durable when it returns. Takes nothing from the heap.
  /// @param entry  next_layer is that of the last one or the one after it
  /// @retval ErrorCode::kCannotWrite  also where the storage is full
  [[nodiscard]] Status append(const JournalEntry& entry);

 private:
  explicit Journal(JournalStorage& storage) : storage_(&storage) {}

  JournalStorage* storage_;
  std::uint64_t job_hash_ = 0;
  std::uint32_t layers_ = 0;
  JournalEntry last_;
  std::size_t records_ = 0;  ///< written
  bool cut_short_ = false;
};

}  // namespace plumbline
