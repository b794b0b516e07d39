#pragma once
/// What the printer keeps of a print while it is at work: the job, to make every mask again, and the journal. Both in one folder
/// of the printer's own storage, so the stick may leave.
///
///   STATE/job       settings, R-Rep and supports, written once before the first layer
///   STATE/journal   what has been cured (firmware/print/journal.hpp)
///
/// The journal is created last and removed first: where it is, the job it speaks of is whole.

#include <cstdint>
#include <optional>
#include <string>

#include "firmware/io/fixed_text.hpp"
#include "firmware/print/journal.hpp"
#include "firmware/print/print_plan.hpp"
#include "slicer/core/arena.hpp"
#include "slicer/rrep/rrep.hpp"
#include "slicer/supports/supports.hpp"

namespace plumbline {

/// A short text of fixed size, ended by 0 where it is shorter.
using ShortName = std::array<char, 64>;
ShortName short_name(std::string_view text);
std::string_view view(const ShortName& name);

/// All that a print is, but its R-Rep and supports. Plain bytes: stored as it is.
struct JobFacts {
  ShortName scan = {};  ///< file name
  ShortName printer = {};
  ShortName profile = {};
  std::uint64_t scan_hash = 0;     ///< of the file's bytes
  std::uint64_t printer_hash = 0;  ///< hash_of() of the board file's values
  std::uint64_t cured_pixels = 0;  ///< of all masks together
  Distance cure_depth;             ///< under the light of a normal layer
  PrintPlan plan;
};

/// Fingerprint of what a printer's file says, whatever its layout and comments.
std::uint64_t hash_of(const BoardFile& board);

/// A journal in a file: pread, pwrite, fdatasync.
class JournalFile final : public JournalStorage {
 public:
  JournalFile() = default;
  JournalFile(JournalFile&& other) noexcept;
  JournalFile& operator=(JournalFile&& other) noexcept;
  ~JournalFile() override;

  std::size_t size() const override { return size_; }
  Status read(std::size_t offset, std::span<std::byte> bytes) override;
  Status write(std::size_t offset, std::span<const std::byte> bytes) override;
  Status sync() override;

 private:
  friend class JobStore;
  int file_ = -1;
  std::size_t size_ = 0;
};

class JobStore {
 public:
  /// Creates the folder where it is missing, and locks it against other processes.
  /// @retval ErrorCode::kCannotOpen, kCannotWrite  the path, the reason
  [[nodiscard]] static Expected<JobStore> open(const std::string& folder);
  JobStore(JobStore&& other) noexcept;
  JobStore& operator=(JobStore&&) = delete;
  ~JobStore();

  /// There is a journal: a print was interrupted.
  bool has_job() const;

  /// Replaces what is there by a new print. Durable when it returns. Takes nothing from the heap.
  /// @returns the storage of its journal, all zeros; begin the journal with `job_hash`
  /// @retval ErrorCode::kCannotWrite
  [[nodiscard]] Expected<JournalFile> begin(const JobFacts& facts, const RRep& rrep, const Supports& supports,
                                            std::uint64_t& job_hash);

  struct Interrupted {
    JobFacts facts;
    RRep rrep;          ///< at the bottom of the arena
    Supports supports;  ///< there, too
    std::uint64_t job_hash = 0;
    JournalFile journal;
  };
  /// Loads the interrupted print.
  /// @retval ErrorCode::kTruncated   there is none
  /// @retval ErrorCode::kMalformed   the job's file is damaged
  /// @retval ErrorCode::kUnsupported it was written by another version of plumbline
  /// @retval ErrorCode::kOutOfMemory, kCannotRead
  [[nodiscard]] Expected<Interrupted> load(Arena& arena);

  /// The print is over: nothing is to be resumed.
  /// @retval ErrorCode::kCannotWrite
  [[nodiscard]] Status end();

 private:
  JobStore() = default;
  [[nodiscard]] Status write_job(const JobFacts& facts, const RRep& rrep, const Supports& supports,
                                 std::uint64_t& job_hash);
  [[nodiscard]] Expected<JournalFile> create_journal(std::uint32_t layers);
  [[nodiscard]] Status sync_folder() const;

  FixedPath path_;
  int folder_ = -1;
};

}  // namespace plumbline
