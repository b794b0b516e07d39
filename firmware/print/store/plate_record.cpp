#include "firmware/print/store/plate_record.hpp"

#include <fcntl.h>
#include <sys/stat.h>
#include <unistd.h>

#include <cerrno>
#include <cstring>

#include "firmware/print/store/file_modes.hpp"

namespace plumbline {
namespace {

constexpr const char* kFile = "plate-is-empty";

}  // namespace

Expected<PlateRecord> PlateRecord::open(const std::string& folder) {
  PlateRecord record;
  record.path_.add("%s/%s", folder.c_str(), kFile);
  record.folder_ = Descriptor(::open(folder.c_str(), O_RDONLY | O_DIRECTORY | O_CLOEXEC));
  if (!record.folder_.is_open()) return fail(ErrorCode::kCannotOpen, "%s: %s", folder.c_str(), std::strerror(errno));
  struct stat facts {};
  record.empty_ = ::fstatat(record.folder_.get(), kFile, &facts, AT_SYMLINK_NOFOLLOW) == 0 && S_ISREG(facts.st_mode);
  return record;
}

tl::unexpected<Error> PlateRecord::cannot_write() const {
  const int reason = errno;
  return fail(ErrorCode::kCannotWrite, "%s: %s", path_.c_str(), std::strerror(reason));
}

Status PlateRecord::take() {
  empty_ = false;
  if (::unlinkat(folder_.get(), kFile, 0) != 0 && errno != ENOENT) return cannot_write();
  return ::fsync(folder_.get()) == 0 ? Status() : Status(cannot_write());
}

Status PlateRecord::confirm_empty() {
  const int flags = O_WRONLY | O_CREAT | O_TRUNC | O_NOFOLLOW | O_NONBLOCK | O_CLOEXEC;
  const Descriptor file(::openat(folder_.get(), kFile, flags, kFileMode));
  if (!file.is_open() || ::fsync(file.get()) != 0 || ::fsync(folder_.get()) != 0) return cannot_write();
  empty_ = true;
  return {};
}

}  // namespace plumbline
