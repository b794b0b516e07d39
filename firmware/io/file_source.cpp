#include "firmware/io/file_source.hpp"

#include <fcntl.h>
#include <sys/stat.h>
#include <unistd.h>

#include <cerrno>
#include <cstring>
#include <utility>

namespace plumbline::firmware {

Expected<FileSource> FileSource::open(const std::string& path) {
  FileSource source;
  source.file_ = ::open(path.c_str(), O_RDONLY | O_CLOEXEC | O_NOCTTY);
  if (source.file_ < 0) {
    const int reason = errno;
    return fail(
        ErrorCode::kCannotOpen, "%s: the scan cannot be opened: %s. %s", path.c_str(), std::strerror(reason),
        reason == ENOENT ? "Check the path; 'plumbline sample bust.ply' makes a scan to try" : "Check its permissions");
  }
  struct stat status = {};
  if (::fstat(source.file_, &status) != 0) {
    return fail(ErrorCode::kCannotOpen, "%s: %s", path.c_str(), std::strerror(errno));
  }
  if (S_ISDIR(status.st_mode)) {
    return fail(ErrorCode::kCannotOpen, "%s: is a folder.\tName the scan in it: a .ply, .pcd, .obj or .xyz file",
                path.c_str());
  }
  if (S_ISREG(status.st_mode)) {
    source.size_ = static_cast<std::uint64_t>(status.st_size);
    // A hint that doubles the kernel's read-ahead; it may fail.
    static_cast<void>(::posix_fadvise(source.file_, 0, 0, POSIX_FADV_SEQUENTIAL));
  }
  source.name_ = path.substr(path.find_last_of('/') + 1);
  return source;
}

FileSource::FileSource(FileSource&& other) noexcept
    : file_(std::exchange(other.file_, -1)),
      name_(std::move(other.name_)),
      size_(other.size_),
      offset_(other.offset_) {}

FileSource::~FileSource() {
  if (file_ >= 0) ::close(file_);
}

Expected<std::size_t> FileSource::read(std::span<std::byte> buffer) {
  for (;;) {
    const ssize_t got = ::read(file_, buffer.data(), buffer.size());
    if (got >= 0) {
      offset_ += static_cast<std::uint64_t>(got);
      return static_cast<std::size_t>(got);
    }
    if (errno == EINTR) continue;
    return fail(ErrorCode::kCannotRead, "%s: reading failed at byte %llu: %s.\tCheck the medium and try again",
                name_.c_str(), static_cast<unsigned long long>(offset_), std::strerror(errno));
  }
}

Status FileSource::rewind() {
  if (::lseek(file_, 0, SEEK_SET) != 0) return ByteSource::rewind();
  offset_ = 0;
  return {};
}

}  // namespace plumbline::firmware
