#include "firmware/print/job_store.hpp"

#include <fcntl.h>
#include <sys/file.h>
#include <sys/stat.h>
#include <unistd.h>

#include <algorithm>
#include <cerrno>
#include <cstring>
#include <limits>
#include <type_traits>
#include <utility>

#include "firmware/io/hash64.hpp"

namespace plumbline {
namespace {

constexpr const char* kJob = "job";
constexpr const char* kJournal = "journal";
constexpr const char* kNewJob = "job.new";
constexpr const char* kNewJournal = "journal.new";
constexpr mode_t kMode = 0644;

/// Begins the job's file. A change of what is stored, JobFacts and PrintPlan included, needs another number.
constexpr std::uint32_t kMagic = 0x424F4A50;  // "PJOB"
constexpr std::uint32_t kVersion = 1;

struct JobHeader {
  std::uint32_t magic = kMagic;
  std::uint32_t version = kVersion;
  std::uint64_t facts_bytes = sizeof(JobFacts);
  std::uint64_t crossings = 0;
  std::uint64_t supports = 0;
  PrintGrid grid;
  SupportShape shape;  ///< of the supports
};
static_assert(std::is_trivially_copyable_v<JobFacts> && std::is_trivially_copyable_v<JobHeader>);
static_assert(std::is_trivially_copyable_v<Support>);

/// A descriptor that is closed.
class File {
 public:
  explicit File(int file) : file_(file) {}
  File(const File&) = delete;
  File& operator=(const File&) = delete;
  ~File() {
    if (file_ >= 0) ::close(file_);
  }
  int get() const { return file_; }
  int release() { return std::exchange(file_, -1); }

 private:
  int file_;
};

bool write_all(int file, std::span<const std::byte> bytes) {
  while (!bytes.empty()) {
    const ssize_t put = ::write(file, bytes.data(), bytes.size());
    if (put < 0 && errno == EINTR) continue;
    if (put < 0) return false;
    bytes = bytes.subspan(static_cast<std::size_t>(put));
  }
  return true;
}

/// @returns false at the end of the file, too, with errno 0
bool read_all(int file, std::span<std::byte> bytes) {
  while (!bytes.empty()) {
    const ssize_t got = ::read(file, bytes.data(), bytes.size());
    if (got < 0 && errno == EINTR) continue;
    if (got == 0) errno = 0;
    if (got <= 0) return false;
    bytes = bytes.subspan(static_cast<std::size_t>(got));
  }
  return true;
}

template <class T>
std::span<const std::byte> bytes_of(const T& value) {
  return std::as_bytes(std::span(&value, 1));
}

tl::unexpected<Error> cannot_write(const char* folder, const char* name, int reason) {
  return fail(ErrorCode::kCannotWrite, "%s/%s: cannot be written: %s. Make room there, or check the storage", folder,
              name, std::strerror(reason));
}

tl::unexpected<Error> cannot_read(const char* folder, const char* name, int reason) {
  if (reason == 0) {
    return fail(ErrorCode::kMalformed,
                "%s/%s: the stored job is cut off: take the part off the plate and start the print anew", folder, name);
  }
  return fail(ErrorCode::kCannotRead, "%s/%s: %s", folder, name, std::strerror(reason));
}

}  // namespace

ShortName short_name(std::string_view text) {
  ShortName name = {};
  std::copy_n(text.begin(), std::min(text.size(), name.size()), name.begin());
  return name;
}

std::string_view view(const ShortName& name) {
  return {name.data(), static_cast<std::size_t>(std::find(name.begin(), name.end(), '\0') - name.begin())};
}

std::uint64_t hash_of(const BoardFile& board) {
  Hash64 hash;
  const auto number = [&hash](double value) { hash.add_value(std::bit_cast<std::uint64_t>(value)); };
  hash.add_text(board.name);
  number(board.columns);
  number(board.rows);
  number(board.pixel_pitch_x_mm);
  number(board.pixel_pitch_y_mm);
  number(board.travel_mm);
  if (board.machine) {
    const MachineFile& m = *board.machine;
    for (const double value : {static_cast<double>(m.panel.rgb), static_cast<double>(m.panel.mirror),
                               static_cast<double>(m.panel.rotation_deg), m.rotation_distance_mm,
                               static_cast<double>(m.full_steps_per_rotation), static_cast<double>(m.microsteps),
                               m.end_stop_height_mm, m.power_mw_cm2}) {
      number(value);
    }
  }
  return hash.value();
}

JournalFile::JournalFile(JournalFile&& other) noexcept
    : file_(std::exchange(other.file_, -1)), size_(std::exchange(other.size_, 0)) {}

JournalFile& JournalFile::operator=(JournalFile&& other) noexcept {
  std::swap(file_, other.file_);
  std::swap(size_, other.size_);
  return *this;
}

JournalFile::~JournalFile() {
  if (file_ >= 0) ::close(file_);
}

Status JournalFile::read(std::size_t offset, std::span<std::byte> bytes) {
  const ssize_t got = ::pread(file_, bytes.data(), bytes.size(), static_cast<off_t>(offset));
  if (got == static_cast<ssize_t>(bytes.size())) return {};
  return fail(ErrorCode::kCannotRead, "the journal can't be read: %s",
              got < 0 ? std::strerror(errno) : "it is cut off");
}

Status JournalFile::write(std::size_t offset, std::span<const std::byte> bytes) {
  const ssize_t put = ::pwrite(file_, bytes.data(), bytes.size(), static_cast<off_t>(offset));
  if (put == static_cast<ssize_t>(bytes.size())) return {};
  return fail(ErrorCode::kCannotWrite, "the journal can't be written: %s",
              put < 0 ? std::strerror(errno) : "the storage is full");
}

Status JournalFile::sync() {
  if (::fdatasync(file_) == 0) return {};
  return fail(ErrorCode::kCannotWrite, "the journal can't be made durable: %s", std::strerror(errno));
}

Expected<JobStore> JobStore::open(const std::string& folder) {
  JobStore store;
  store.path_.add("%s", folder.c_str());
  if (::mkdir(folder.c_str(), 0755) != 0 && errno != EEXIST) {
    return fail(ErrorCode::kCannotOpen, "%s: cannot be created: %s", folder.c_str(), std::strerror(errno));
  }
  store.folder_ = ::open(folder.c_str(), O_RDONLY | O_DIRECTORY | O_CLOEXEC);
  if (store.folder_ < 0) return fail(ErrorCode::kCannotOpen, "%s: %s", folder.c_str(), std::strerror(errno));
  if (::flock(store.folder_, LOCK_EX | LOCK_NB) != 0) {
    return fail(ErrorCode::kCannotWrite, "%s: another plumbline prints with it; give another one with --state",
                folder.c_str());
  }
  if (::faccessat(store.folder_, ".", W_OK, AT_EACCESS) != 0) return cannot_write(folder.c_str(), kJob, errno);
  return store;
}

JobStore::JobStore(JobStore&& other) noexcept : path_(other.path_), folder_(std::exchange(other.folder_, -1)) {}

JobStore::~JobStore() {
  if (folder_ >= 0) ::close(folder_);
}

bool JobStore::has_job() const { return ::faccessat(folder_, kJournal, F_OK, 0) == 0; }

Status JobStore::sync_folder() const {
  return ::fsync(folder_) == 0 ? Status() : Status(cannot_write(path_.c_str(), ".", errno));
}

Status JobStore::end() {
  if (::unlinkat(folder_, kJournal, 0) != 0 && errno != ENOENT) return cannot_write(path_.c_str(), kJournal, errno);
  PLUMBLINE_TRY(sync_folder());
  // Nothing speaks of it any more; it only takes room.
  static_cast<void>(::unlinkat(folder_, kJob, 0));
  return {};
}

Expected<JournalFile> JobStore::begin(const JobFacts& facts, const RRep& rrep, const Supports& supports,
                                      std::uint64_t& job_hash) {
  PLUMBLINE_TRY(end());
  PLUMBLINE_TRY(write_job(facts, rrep, supports, job_hash));
  return create_journal(rrep.grid.layers);
}

Status JobStore::write_job(const JobFacts& facts, const RRep& rrep, const Supports& supports, std::uint64_t& job_hash) {
  const File file(::openat(folder_, kNewJob, O_WRONLY | O_CREAT | O_TRUNC | O_CLOEXEC, kMode));
  const char* folder = path_.c_str();
  if (file.get() < 0) return cannot_write(folder, kNewJob, errno);
  JobHeader header;
  header.crossings = rrep.crossings();
  header.supports = supports.list.size();
  header.grid = rrep.grid;
  header.shape = supports.shape;
  Hash64 hash;
  const std::span<const std::byte> parts[] = {bytes_of(header), bytes_of(facts), std::as_bytes(rrep.first),
                                              std::as_bytes(rrep.pixel), std::as_bytes(supports.list)};
  for (const auto part : parts) {
    hash.add(part);
    if (!write_all(file.get(), part)) return cannot_write(folder, kNewJob, errno);
  }
  job_hash = hash.value();
  if (!write_all(file.get(), bytes_of(job_hash)) || ::fdatasync(file.get()) != 0 ||
      ::renameat(folder_, kNewJob, folder_, kJob) != 0) {
    return cannot_write(folder, kNewJob, errno);
  }
  return sync_folder();
}

Expected<JournalFile> JobStore::create_journal(std::uint32_t layers) {
  const char* folder = path_.c_str();
  File file(::openat(folder_, kNewJournal, O_RDWR | O_CREAT | O_TRUNC | O_CLOEXEC, kMode));
  if (file.get() < 0) return cannot_write(folder, kNewJournal, errno);
  const std::size_t size = Journal::bytes_needed(layers);
  // Written, not reserved: an append must not have to find room, nor change the file's map.
  constexpr std::array<std::byte, 4096> kZeros = {};
  for (std::size_t done = 0; done < size; done += kZeros.size()) {
    if (!write_all(file.get(), std::span(kZeros).first(std::min(kZeros.size(), size - done)))) {
      return cannot_write(folder, kNewJournal, errno);
    }
  }
  if (::fsync(file.get()) != 0 || ::renameat(folder_, kNewJournal, folder_, kJournal) != 0) {
    return cannot_write(folder, kNewJournal, errno);
  }
  PLUMBLINE_TRY(sync_folder());
  JournalFile journal;
  journal.file_ = file.release();
  journal.size_ = size;
  return journal;
}

Expected<JobStore::Interrupted> JobStore::load(Arena& arena) {
  const char* folder = path_.c_str();
  File journal(::openat(folder_, kJournal, O_RDWR | O_CLOEXEC));
  if (journal.get() < 0 && errno == ENOENT) {
    return fail(ErrorCode::kTruncated, "%s: no interrupted print is stored here", folder);
  }
  if (journal.get() < 0) return cannot_read(folder, kJournal, errno);
  struct stat facts_of_journal {};
  if (::fstat(journal.get(), &facts_of_journal) != 0) return cannot_read(folder, kJournal, errno);
  const File file(::openat(folder_, kJob, O_RDONLY | O_CLOEXEC));
  if (file.get() < 0) return cannot_read(folder, kJob, errno == ENOENT ? 0 : errno);

  JobHeader header;
  if (!read_all(file.get(), std::as_writable_bytes(std::span(&header, 1)))) return cannot_read(folder, kJob, errno);
  if (header.magic != kMagic) return cannot_read(folder, kJob, 0);
  if (header.version != kVersion || header.facts_bytes != sizeof(JobFacts)) {
    return fail(ErrorCode::kUnsupported, "%s/%s: stored by another version of plumbline, which alone can resume it",
                folder, kJob);
  }
  // More than a size_t counts, on a board of 32 bits: the arena refuses what is merely too much.
  constexpr std::uint64_t kMost = std::numeric_limits<std::size_t>::max() / sizeof(Support);
  if (header.crossings > kMost || header.supports > kMost) return cannot_read(folder, kJob, 0);
  if (header.grid.layers == 0 || header.grid.layers > PrintGrid::kMaxLayers) return cannot_read(folder, kJob, 0);
  Interrupted job;
  if (!read_all(file.get(), std::as_writable_bytes(std::span(&job.facts, 1)))) return cannot_read(folder, kJob, errno);
  const auto first = arena.take_bottom<std::uint32_t>(std::size_t{header.grid.layers} + 1, "r-rep");
  PLUMBLINE_TRY(first);
  const auto pixel = arena.take_bottom<std::uint32_t>(static_cast<std::size_t>(header.crossings), "r-rep");
  PLUMBLINE_TRY(pixel);
  const auto supports = arena.take_bottom<Support>(static_cast<std::size_t>(header.supports), "supports");
  PLUMBLINE_TRY(supports);
  std::uint64_t stored = 0;
  if (!read_all(file.get(), std::as_writable_bytes(*first)) || !read_all(file.get(), std::as_writable_bytes(*pixel)) ||
      !read_all(file.get(), std::as_writable_bytes(*supports)) ||
      !read_all(file.get(), std::as_writable_bytes(std::span(&stored, 1)))) {
    return cannot_read(folder, kJob, errno);
  }
  Hash64 hash;
  const std::span<const std::byte> parts[] = {bytes_of(header), bytes_of(job.facts), std::as_bytes(*first),
                                              std::as_bytes(*pixel), std::as_bytes(*supports)};
  for (const auto part : parts) hash.add(part);
  if (hash.value() != stored) {
    return fail(ErrorCode::kMalformed,
                "%s/%s: the stored job is damaged and is not followed: take the part off the plate and start the print "
                "anew",
                folder, kJob);
  }
  job.rrep = {.grid = header.grid, .first = *first, .pixel = *pixel};
  job.supports = {.list = *supports, .shape = header.shape};
  job.job_hash = stored;
  job.journal.size_ = static_cast<std::size_t>(facts_of_journal.st_size);
  job.journal.file_ = journal.release();
  return job;
}

}  // namespace plumbline
