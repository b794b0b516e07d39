#pragma once
/// Stores a print on the printer, so that the stick can be pulled and the print survives a power cut:
///
///   STATE/job       settings, R-Rep and supports, written once before the first layer (job_file.hpp)
///   STATE/archive   instead of the R-Rep: the archive that somebody else has sliced, byte for byte
///   STATE/journal   what has been cured (journal.hpp)
///
/// The journal is created last and removed first, so if it exists, its job is complete.

#include <cstdint>
#include <string>

#include "firmware/io/descriptor.hpp"
#include "firmware/io/text/fixed_text.hpp"
#include "firmware/print/job/job_file.hpp"
#include "firmware/print/job/journal_file.hpp"
#include "slicer/core/byte_source.hpp"
#include "slicer/core/function_ref.hpp"

namespace plumbline::firmware {

class JobStore {
 public:
  /// Left free on the printer's storage when a scan or an archive is copied there: for the journal and the system's own logs.
  static constexpr std::uint64_t kSpareBytes = std::uint64_t{16} << 20U;

  /// Creates the folder if it is missing, and locks it against other processes.
  /// @retval ErrorCode::kCannotOpen, kCannotWrite  the path, the reason
  [[nodiscard]] static Expected<JobStore> open(const std::string& folder);

  /// Whether there is a journal, which means that a print was interrupted.
  bool has_job() const;

  /// Replaces anything stored with a new print. Durable when it returns. Takes nothing from the heap.
  /// After an error no print is stored, or still the old one if that could not be removed.
  /// @returns its journal, for Journal::open()
  /// @retval ErrorCode::kCannotWrite
  /// @pre for an archive: receive() has copied it
  [[nodiscard]] Expected<JournalFile> begin(const JobFacts& facts, const MaskParts& parts);

  struct Received {
    Descriptor file;         ///< to read the copy
    std::uint64_t hash = 0;  ///< of its bytes
  };
  /// Copies an archive, for a print that begins later. Durable when it returns; a second call, drop_received() and open() remove it.
  /// @param advance  called with the share that is copied; its error ends the copying
  /// @retval ErrorCode::kCannotWrite  also if there is not enough room: how much is needed
  /// @retval any error of advance() and archive.read()
  [[nodiscard]] Expected<Received> receive(ByteSource& archive, FunctionRef<Status(double)> advance);
  /// Removes what receive() has copied, if no print of it has begun.
  void drop_received();

  struct Interrupted {
    StoredJob job;
    JournalFile journal;
    Descriptor archive;  ///< of an archive's print
  };
  /// Loads the interrupted print.
  /// @retval ErrorCode::kTruncated  there is none
  /// @retval any error of read_job()
  [[nodiscard]] Expected<Interrupted> load(Arena& arena);

  struct Progress {
    std::uint64_t job_hash = 0;  ///< of its journal
    JournalEntry last;
  };
  /// How far the interrupted print has come, without loading it.
  /// @retval ErrorCode::kTruncated  there is none
  /// @retval ErrorCode::kCannotRead, and any error of Journal::open()
  [[nodiscard]] Expected<Progress> progress() const;

  /// Removes the print: there is nothing to resume.
  /// @retval ErrorCode::kCannotWrite
  [[nodiscard]] Status end();

 private:
  JobStore() = default;
  [[nodiscard]] Expected<JournalFile> write(const JobFacts& facts, const MaskParts& parts);
  [[nodiscard]] Status write_job_file(const JobFacts& facts, const MaskParts& parts, std::uint64_t& job_hash);
  [[nodiscard]] Expected<JournalFile> create_journal(std::uint64_t job_hash, std::uint32_t layers);
  [[nodiscard]] Expected<JournalFile> open_journal() const;
  [[nodiscard]] Status sync_folder() const;
  FixedPath path_of(const char* name) const;
  tl::unexpected<Error> cannot_write(const char* name) const;
  tl::unexpected<Error> cannot_read(const char* name) const;

  FixedPath path_;
  Descriptor folder_;
};

}  // namespace plumbline::firmware
