#include "firmware/print/job/job_store.hpp"

#include <fcntl.h>
#include <sys/file.h>
#include <sys/stat.h>
#include <sys/statvfs.h>
#include <unistd.h>

#include <algorithm>
#include <array>
#include <cerrno>
#include <cstring>
#include <utility>

#include "firmware/io/hash64.hpp"

namespace plumbline::firmware {
namespace {

constexpr const char* kJob = "job";
constexpr const char* kJournal = "journal";
constexpr const char* kNewJob = "job.new";
constexpr const char* kNewJournal = "journal.new";
constexpr const char* kArchive = "archive";
constexpr const char* kNewArchive = "archive.new";

}  // namespace

FixedPath JobStore::path_of(const char* name) const {
  FixedPath path = path_;
  path.add("/%s", name);
  return path;
}

tl::unexpected<Error> JobStore::cannot_write(const char* name) const {
  const int reason = errno;
  return fail(ErrorCode::kCannotWrite, "%s: cannot be written: %s", path_of(name).c_str(), std::strerror(reason));
}

tl::unexpected<Error> JobStore::cannot_read(const char* name) const {
  const int reason = errno;
  return fail(ErrorCode::kCannotRead, "%s: %s", path_of(name).c_str(), std::strerror(reason));
}

Expected<JobStore> JobStore::open(const std::string& folder) {
  JobStore store;
  store.path_.add("%s", folder.c_str());
  if (::mkdir(folder.c_str(), kFolderMode) != 0 && errno != EEXIST) {
    return fail(ErrorCode::kCannotOpen, "%s: cannot be created: %s", folder.c_str(), std::strerror(errno));
  }
  store.folder_ = Descriptor(::open(folder.c_str(), O_RDONLY | O_DIRECTORY | O_CLOEXEC));
  if (!store.folder_.is_open()) return fail(ErrorCode::kCannotOpen, "%s: %s", folder.c_str(), std::strerror(errno));
  if (::flock(store.folder_.get(), LOCK_EX | LOCK_NB) != 0) {
    return fail(ErrorCode::kCannotWrite,
                "%s: another plumbline is printing with this folder;\tgive another one with --state", folder.c_str());
  }
  if (::faccessat(store.folder_.get(), ".", W_OK, AT_EACCESS) != 0) return store.cannot_write(kJob);
  store.drop_received();
  return store;
}

bool JobStore::has_job() const { return ::faccessat(folder_.get(), kJournal, F_OK, 0) == 0; }

Status JobStore::sync_folder() const { return ::fsync(folder_.get()) == 0 ? Status() : Status(cannot_write(".")); }

Status JobStore::end() {
  if (::unlinkat(folder_.get(), kJournal, 0) != 0 && errno != ENOENT) return cannot_write(kJournal);
  PLUMBLINE_TRY(sync_folder());
  // Without its journal the job only takes up room, so a failure is harmless.
  for (const char* name : {kJob, kArchive}) static_cast<void>(::unlinkat(folder_.get(), name, 0));
  return {};
}

Expected<JournalFile> JobStore::begin(const JobFacts& facts, const MaskParts& parts) {
  PLUMBLINE_TRY(end());
  auto journal = write(facts, parts);
  if (!journal) {
    for (const char* name : {kNewJob, kNewJournal, kNewArchive, kJournal, kJob, kArchive})
      ::unlinkat(folder_.get(), name, 0);
  }
  return journal;
}

Expected<JournalFile> JobStore::write(const JobFacts& facts, const MaskParts& parts) {
  std::uint64_t job_hash = 0;
  if (parts.is_archive() && ::renameat(folder_.get(), kNewArchive, folder_.get(), kArchive) != 0) {
    return cannot_write(kNewArchive);
  }
  PLUMBLINE_TRY(write_job_file(facts, parts, job_hash));
  return create_journal(job_hash, facts.contract.plan.steps.layers(parts.rrep.grid.layers));
}

Status JobStore::write_job_file(const JobFacts& facts, const MaskParts& parts, std::uint64_t& job_hash) {
  const Descriptor file(::openat(folder_.get(), kNewJob, O_WRONLY | O_CREAT | O_TRUNC | O_CLOEXEC, kFileMode));
  if (!file.is_open() || !write_job(file, facts, parts, job_hash) || ::fdatasync(file.get()) != 0 ||
      ::renameat(folder_.get(), kNewJob, folder_.get(), kJob) != 0) {
    return cannot_write(kNewJob);
  }
  return sync_folder();
}

Expected<JournalFile> JobStore::create_journal(std::uint64_t job_hash, std::uint32_t layers) {
  Descriptor descriptor(::openat(folder_.get(), kNewJournal, O_RDWR | O_CREAT | O_TRUNC | O_CLOEXEC, kFileMode));
  if (!descriptor.is_open()) return cannot_write(kNewJournal);
  JournalFile file(std::move(descriptor), Journal::bytes_needed(layers));
  PLUMBLINE_TRY(Journal::create(file, job_hash, layers));
  if (::renameat(folder_.get(), kNewJournal, folder_.get(), kJournal) != 0) return cannot_write(kNewJournal);
  PLUMBLINE_TRY(sync_folder());
  return file;
}

Expected<JobStore::Received> JobStore::receive(ByteSource& archive, FunctionRef<Status(double)> advance) {
  drop_received();
  struct statvfs room = {};
  const std::uint64_t size = archive.size().value_or(0);
  if (::fstatvfs(folder_.get(), &room) == 0) {
    const std::uint64_t free = std::uint64_t{room.f_bavail} * room.f_frsize;
    if (free < size + kSpareBytes) {
      constexpr double kMb = 1e6;
      return fail(ErrorCode::kCannotWrite,
                  "%s: the copy of the archive needs %.0f MB, %.0f MB are free.\tMake room there", path_.c_str(),
                  static_cast<double>(size + kSpareBytes) / kMb, static_cast<double>(free) / kMb);
    }
  }
  const Descriptor file(::openat(folder_.get(), kNewArchive, O_WRONLY | O_CREAT | O_EXCL | O_CLOEXEC, kFileMode));
  if (!file.is_open()) return cannot_write(kNewArchive);
  Hash64 hash;
  std::array<std::byte, 65536> block;  // NOLINT(cppcoreguidelines-pro-type-member-init)
  const auto copy = [&]() -> Status {
    for (std::uint64_t copied = 0;;) {
      PLUMBLINE_TRY(advance(size > 0 ? std::min(1.0, static_cast<double>(copied) / static_cast<double>(size)) : 0));
      const auto got = archive.read(block);
      PLUMBLINE_TRY(got);
      if (*got == 0) break;
      // A file that is being written to must not fill the storage.
      if (copied + *got > size) return fail(ErrorCode::kMalformed, "has grown while it was copied.\tStart again");
      copied += *got;
      hash.add(std::span(block).first(*got));
      if (!file.write_all(std::span(block).first(*got))) return cannot_write(kNewArchive);
    }
    return ::fdatasync(file.get()) == 0 ? Status() : Status(cannot_write(kNewArchive));
  };
  const auto copied = copy();
  Descriptor again(copied ? ::openat(folder_.get(), kNewArchive, O_RDONLY | O_CLOEXEC) : -1);
  if (!copied || !again.is_open()) {
    const Status error = copied ? Status(cannot_read(kNewArchive)) : copied;
    drop_received();
    return tl::unexpected<Error>(error.error());
  }
  return Received{std::move(again), hash.value()};
}

void JobStore::drop_received() { static_cast<void>(::unlinkat(folder_.get(), kNewArchive, 0)); }

Expected<JournalFile> JobStore::open_journal() const {
  Descriptor file(::openat(folder_.get(), kJournal, O_RDWR | O_CLOEXEC));
  if (!file.is_open() && errno == ENOENT) {
    return fail(ErrorCode::kTruncated, "%s: no interrupted print is stored here", path_.c_str());
  }
  struct stat facts {};
  if (!file.is_open() || ::fstat(file.get(), &facts) != 0) return cannot_read(kJournal);
  return JournalFile(std::move(file), static_cast<std::size_t>(facts.st_size));
}

Expected<JobStore::Progress> JobStore::progress() const {
  auto file = open_journal();
  PLUMBLINE_TRY(file);
  const auto journal = Journal::open(*file);
  PLUMBLINE_TRY(journal);
  return Progress{.job_hash = journal->job_hash(), .last = journal->last()};
}

Expected<JobStore::Interrupted> JobStore::load(Arena& arena) {
  auto journal = open_journal();
  PLUMBLINE_TRY(journal);
  const FixedPath path = path_of(kJob);
  const Descriptor file(::openat(folder_.get(), kJob, O_RDONLY | O_CLOEXEC));
  if (!file.is_open() && errno == ENOENT) {
    return fail(ErrorCode::kMalformed, "%s: the stored job is missing and can't be resumed", path.c_str());
  }
  if (!file.is_open()) return cannot_read(kJob);
  const auto job = read_job(file, path.c_str(), arena);
  PLUMBLINE_TRY(job);
  Descriptor archive;
  if (job->parts.is_archive()) {
    archive = Descriptor(::openat(folder_.get(), kArchive, O_RDONLY | O_CLOEXEC));
    if (!archive.is_open()) return cannot_read(kArchive);
  }
  return Interrupted{.job = *job, .journal = std::move(*journal), .archive = std::move(archive)};
}

}  // namespace plumbline::firmware
