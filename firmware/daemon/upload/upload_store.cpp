#include "firmware/daemon/upload/upload_store.hpp"

#include <dirent.h>
#include <fcntl.h>
#include <sys/stat.h>
#include <sys/statvfs.h>

#include <cerrno>
#include <cstring>
#include <memory>
#include <utility>

#include "firmware/messages/printer_code.hpp"
#include "firmware/print/job/job_store.hpp"
#include "slicer/core/numbers/mib.hpp"

namespace plumbline::firmware {
namespace {

constexpr const char* kIncoming = ".incoming";
constexpr mode_t kUploadFileMode = 0600;
constexpr mode_t kUploadFolderMode = 0700;

bool is_newer(const timespec& a, const timespec& b) {
  return a.tv_sec != b.tv_sec ? a.tv_sec > b.tv_sec : a.tv_nsec > b.tv_nsec;
}

struct ListingEnd {
  void operator()(DIR* listing) const { ::closedir(listing); }
};

}  // namespace

tl::unexpected<Error> UploadStore::cannot_write() {
  const int reason = errno;
  drop();
  return telling(
      Told(PrinterCode::kUploadNotStored),
      fail(ErrorCode::kCannotWrite, "the scan can't be stored: %s.\tMake room on the printer, or use a stick",
           reason == ENOSPC ? "the printer's storage is full" : std::strerror(reason)));
}

Expected<UploadStore> UploadStore::open(const std::string& state, std::uint64_t most_bytes) {
  UploadStore store;
  store.most_bytes_ = most_bytes;
  store.path_.add("%s/uploads", state.c_str());
  const char* const path = store.path_.c_str();
  if (::mkdir(path, kUploadFolderMode) != 0 && errno != EEXIST) {
    return fail(ErrorCode::kCannotOpen, "%s: cannot be created: %s", path, std::strerror(errno));
  }
  store.folder_ = Descriptor(::open(path, O_RDONLY | O_DIRECTORY | O_CLOEXEC | O_NOFOLLOW));
  if (!store.folder_.is_open()) return fail(ErrorCode::kCannotOpen, "%s: %s", path, std::strerror(errno));
  PLUMBLINE_TRY(store.tidy());
  return store;
}

/// Removes all but the newest scan: a power cut may have come between keeping one and removing the one before.
Status UploadStore::tidy() {
  const int again = open_folder();
  const std::unique_ptr<DIR, ListingEnd> listing(again < 0 ? nullptr : ::fdopendir(again));
  if (!listing) {
    const int reason = errno;
    if (again >= 0) ::close(again);
    return fail(ErrorCode::kCannotRead, "%s: %s", path_.c_str(), std::strerror(reason));
  }
  timespec newest{};
  while (const dirent* const entry = ::readdir(listing.get())) {
    const std::string_view name(entry->d_name);
    if (name == "." || name == "..") continue;
    struct stat facts {};
    const bool counts = name.front() != '.' && ::fstatat(again, entry->d_name, &facts, AT_SYMLINK_NOFOLLOW) == 0 &&
                        S_ISREG(facts.st_mode);
    if (counts && (kept_.view().empty() || is_newer(facts.st_mtim, newest))) {
      if (!kept_.view().empty()) static_cast<void>(::unlinkat(again, kept_.c_str(), 0));
      kept_.clear();
      kept_.add("%s", entry->d_name);
      kept_bytes_ = static_cast<std::uint64_t>(facts.st_size);
      newest = facts.st_mtim;
    } else if (::unlinkat(again, entry->d_name, 0) != 0 && errno == EISDIR) {
      static_cast<void>(::unlinkat(again, entry->d_name, AT_REMOVEDIR));  // nobody but people makes one
    }
  }
  return {};
}

int UploadStore::open_folder() const { return ::openat(folder_.get(), ".", O_RDONLY | O_DIRECTORY | O_CLOEXEC); }

Status UploadStore::begin(std::string_view name, std::uint64_t bytes) {
  drop();
  if (bytes == 0)
    return telling(Told(PrinterCode::kUploadEmpty),
                   fail(ErrorCode::kBadSetting, "the file is empty.\tExport the scan again"));
  if (bytes > most_bytes_) {
    return telling(
        Told(PrinterCode::kUploadLarge, {{Fact::kNeededMib, mib(bytes)}, {Fact::kAvailableMib, mib(most_bytes_)}}),
        fail(ErrorCode::kBadSetting,
             "the file has %.1f MiB, and this printer takes %.0f MiB at most.\tUse a stick, or raise [printer] "
             "upload_mib",
             mib(bytes), mib(most_bytes_)));
  }
  struct statvfs room {};
  if (::fstatvfs(folder_.get(), &room) != 0) return cannot_write();
  const std::uint64_t free = std::uint64_t{room.f_bavail} * room.f_frsize;
  if (free < JobStore::kSpareBytes || bytes > free - JobStore::kSpareBytes) {
    return telling(
        Told(PrinterCode::kUploadNoRoom,
             {{Fact::kNeededMib, mib(bytes + JobStore::kSpareBytes)}, {Fact::kAvailableMib, mib(free)}}),
        fail(ErrorCode::kCannotWrite,
             "the printer's storage has %.0f MiB free, and this scan needs %.0f MiB.\tMake room on it, or use a stick",
             mib(free), mib(bytes + JobStore::kSpareBytes)));
  }
  file_ = Descriptor(
      ::openat(folder_.get(), kIncoming, O_WRONLY | O_CREAT | O_EXCL | O_NOFOLLOW | O_CLOEXEC, kUploadFileMode));
  if (!file_.is_open()) return cannot_write();
  // Takes the room now, where the file system can, so that nobody sends all of it in vain.
  if (::fallocate(file_.get(), FALLOC_FL_KEEP_SIZE, 0, static_cast<off_t>(bytes)) != 0 && errno != EOPNOTSUPP &&
      errno != EINTR) {
    return cannot_write();
  }
  name_.clear();
  name_.add("%.*s", static_cast<int>(name.size()), name.data());
  bytes_ = bytes;
  written_ = durable_ = 0;
  return {};
}

Status UploadStore::write(std::span<const std::byte> bytes) {
  if (bytes.size() > bytes_ - written_) {
    drop();
    return fail(ErrorCode::kBadSetting, "more bytes arrived than were announced.\tSend the scan again");
  }
  if (!file_.write_all(bytes)) return cannot_write();
  written_ += bytes.size();
  if (written_ - durable_ < kDurableBytes) return {};
  durable_ = written_;
  return ::fdatasync(file_.get()) == 0 ? Status() : Status(cannot_write());
}

Status UploadStore::keep() {
  if (::fsync(file_.get()) != 0 || ::renameat(folder_.get(), kIncoming, folder_.get(), name_.c_str()) != 0) {
    return cannot_write();
  }
  const Descriptor whole(std::exchange(file_, Descriptor()));
  if (!kept_.view().empty() && kept_.view() != name_.view()) {
    static_cast<void>(::unlinkat(folder_.get(), kept_.c_str(), 0));
  }
  kept_.clear();
  kept_.add("%s", name_.c_str());
  kept_bytes_ = bytes_;
  ++kept_count_;
  if (::fsync(folder_.get()) != 0) {
    return telling(
        Told(PrinterCode::kUploadNotStored),
        fail(ErrorCode::kCannotWrite, "the scan may be gone after a power cut: %s.\tCheck the printer's storage",
             std::strerror(errno)));
  }
  return {};
}

Status UploadStore::remove() {
  if (kept_.view().empty()) return {};
  if (::unlinkat(folder_.get(), kept_.c_str(), 0) != 0 && errno != ENOENT) {
    return telling(Told(PrinterCode::kNotRemoved),
                   fail(ErrorCode::kCannotWrite, "the scan can't be removed: %s.\tCheck the printer's storage",
                        std::strerror(errno)));
  }
  kept_.clear();
  kept_bytes_ = 0;
  ++kept_count_;
  if (::fsync(folder_.get()) != 0) {
    return telling(
        Told(PrinterCode::kNotRemoved),
        fail(ErrorCode::kCannotWrite, "the scan may be there again after a power cut: %s.\tCheck the printer's storage",
             std::strerror(errno)));
  }
  return {};
}

void UploadStore::drop() {
  const Descriptor gone(std::exchange(file_, Descriptor()));
  bytes_ = written_ = durable_ = 0;
  static_cast<void>(::unlinkat(folder_.get(), kIncoming, 0));
}

}  // namespace plumbline::firmware
