#pragma once
/// The journal of a print: what has been cured, durable layer by layer, so that a print can resume after a power cut.
///
/// A header and then one record for each layer, each 64 bytes that end with a hash of those before. The file has its full size and
/// is all zeros when a print begins, so a record cut short by the power ends in zeros; it counts as never written. Anything else
/// that does not add up is damage: it is reported, and the print is not resumed.

#include <cstddef>
#include <cstdint>
#include <optional>
#include <span>

#include "hal/clock.hpp"
#include "hal/units.hpp"
#include "slicer/core/error.hpp"

namespace plumbline {

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
  /// Makes all writes durable.
  /// @retval ErrorCode::kCannotWrite
  [[nodiscard]] virtual Status sync() = 0;
};

/// How far a print has come.
struct JournalEntry {
  std::uint32_t next_layer = 0;    ///< all layers before it are cured
  ZPosition height;                ///< of the last cured layer; 0 before the first
  std::uint64_t cured_pixels = 0;  ///< of all cured layers
  nanoseconds elapsed{};           ///< printing time, over all runs
  nanoseconds lit{};               ///< light that next_layer has had already, if the print was stopped during it
  bool operator==(const JournalEntry&) const = default;
};

class Journal {
 public:
  static constexpr std::size_t kRecordBytes = 64;
  /// Room beyond one record a layer: one for each time that the print resumes. Far more than a print has power cuts, and 64 KiB.
  static constexpr std::size_t kSpareRecords = 1024;

  /// @returns bytes of storage
  static constexpr std::size_t bytes_needed(std::uint32_t layers) {
    return kRecordBytes * (1 + std::size_t{layers} + kSpareRecords);
  }

  /// Writes the header of a new print.
  /// @param storage   all zeros, bytes_needed(layers) or more; outlives the journal
  /// @param job_hash  of the job that the entries are about (JobStore)
  /// @retval ErrorCode::kCannotWrite
  [[nodiscard]] static Expected<Journal> create(JournalStorage& storage, std::uint64_t job_hash, std::uint32_t layers);

  /// Reads the journal of an interrupted print.
  /// @retval ErrorCode::kTruncated  there is none: the power was cut while it was created, before the first layer
  /// @retval ErrorCode::kMalformed  damaged, at which record: the print must not resume
  /// @retval ErrorCode::kCannotRead
  [[nodiscard]] static Expected<Journal> open(JournalStorage& storage);

  std::uint64_t job_hash() const { return job_hash_; }
  std::uint32_t layers() const { return layers_; }
  /// The last entry; a default one before the first layer.
  const JournalEntry& last() const { return last_; }
  /// open() found a record that the power cut short.
  bool cut_short() const { return cut_short_; }

  /// Durable when it returns. Takes nothing from the heap.
  /// @param entry  next_layer is that of the last entry or one more
  /// @retval ErrorCode::kCannotWrite  also if the journal is full
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
