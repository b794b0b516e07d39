#include "firmware/io/output_file.hpp"

#include <fcntl.h>
#include <sys/stat.h>
#include <unistd.h>

#include <cerrno>
#include <cstdio>
#include <cstring>
#include <utility>

namespace plumbline::firmware {
namespace {

constexpr mode_t kMode = 0666;  ///< less the user's umask
constexpr int kFlags = O_WRONLY | O_CREAT | O_CLOEXEC | O_NOCTTY;

tl::unexpected<Error> cannot_create(const char* path, int reason) {
  return fail(ErrorCode::kCannotOpen, "%s: cannot be created: %s.\tCheck the folder, or choose another one", path,
              std::strerror(reason));
}

}  // namespace

Expected<OutputFile> OutputFile::create(const char* path) {
  OutputFile file;
  file.path_.add("%s", path);
  file.file_ = ::open(path, kFlags | O_TRUNC, kMode);
  if (file.file_ < 0) return cannot_create(path, errno);
  return file;
}

OutputFile OutputFile::standard_output() {
  OutputFile file;
  file.path_.add("standard output");
  file.file_ = STDOUT_FILENO;
  file.owned_ = false;
  return file;
}

OutputFile::OutputFile(OutputFile&& other) noexcept
    : file_(std::exchange(other.file_, -1)), owned_(other.owned_), path_(other.path_) {}

OutputFile::~OutputFile() {
  if (owned_ && file_ >= 0) ::close(file_);
}

tl::unexpected<Error> OutputFile::cannot_write(int reason) const {
  return fail(ErrorCode::kCannotWrite, "%s: cannot be written: %s. %s", path_.c_str(), std::strerror(reason),
              reason == ENOSPC || reason == EDQUOT || reason == EFBIG ? "Make room there, or choose another folder"
                                                                      : "Check the medium, or choose another folder");
}

Status OutputFile::write(std::span<const std::byte> bytes) {
  while (!bytes.empty()) {
    const ssize_t put = ::write(file_, bytes.data(), bytes.size());
    if (put < 0) {
      if (errno == EINTR) continue;
      return cannot_write(errno);
    }
    bytes = bytes.subspan(static_cast<std::size_t>(put));
  }
  return {};
}

Status OutputFile::close() {
  if (!owned_) return {};
  const int file = std::exchange(file_, -1);
  // EINTR of close() leaves the file closed on Linux.
  if (::close(file) != 0 && errno != EINTR) return cannot_write(errno);
  return {};
}

Status check_can_create(const char* path) {
  struct stat status = {};
  const bool is_there = ::lstat(path, &status) == 0;
  // O_NONBLOCK: a pipe that nobody reads yet must not block, and is no error.
  const int file = ::open(path, kFlags | O_NONBLOCK, kMode);
  if (file < 0) return errno == ENXIO ? Status() : Status(cannot_create(path, errno));
  ::close(file);
  if (!is_there) ::unlink(path);
  return {};
}

Status write_whole_file(const char* path, FunctionRef<Status(TextSink&)> write) {
  FixedPath unfinished;
  unfinished.add("%s.new", path);
  const auto attempt = [&]() -> Status {
    if (::unlink(path) != 0 && errno != ENOENT) return cannot_create(path, errno);
    auto file = OutputFile::create(unfinished.c_str());
    PLUMBLINE_TRY(file);
    PLUMBLINE_TRY(write(*file));
    PLUMBLINE_TRY(file->close());
    return ::rename(unfinished.c_str(), path) == 0 ? Status() : Status(cannot_create(path, errno));
  };
  auto written = attempt();
  if (!written) static_cast<void>(::unlink(unfinished.c_str()));
  return written;
}

Status write_file(const char* path, std::span<const std::byte> bytes) {
  auto file = OutputFile::create(path);
  PLUMBLINE_TRY(file);
  PLUMBLINE_TRY(file->write(bytes));
  return file->close();
}

}  // namespace plumbline::firmware
