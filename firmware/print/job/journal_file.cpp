#include "firmware/print/job/journal_file.hpp"

#include <fcntl.h>
#include <unistd.h>

#include <cerrno>
#include <cstring>

namespace plumbline::firmware {
namespace {

/// Moves all bytes with `move(bytes, offset)`, which is pread() or pwrite().
/// @returns false: errno has the reason, 0 at the end of the file
template <class Bytes, class Move>
bool move_all(Bytes bytes, std::size_t offset, Move move) {
  while (!bytes.empty()) {
    const ssize_t moved = move(bytes, static_cast<off_t>(offset));
    if (moved < 0 && errno == EINTR) continue;
    if (moved == 0) errno = 0;
    if (moved <= 0) return false;
    bytes = bytes.subspan(static_cast<std::size_t>(moved));
    offset += static_cast<std::size_t>(moved);
  }
  return true;
}

const char* reason(const char* at_end) { return errno == 0 ? at_end : std::strerror(errno); }

}  // namespace

Status JournalFile::read(std::size_t offset, std::span<std::byte> bytes) {
  const auto read_some = [this](std::span<std::byte> rest, off_t at) {
    return ::pread(file_.get(), rest.data(), rest.size(), at);
  };
  if (move_all(bytes, offset, read_some)) return {};
  return fail(ErrorCode::kCannotRead, "%s can't be read: %s", what_, reason("the file is cut off"));
}

Status JournalFile::write(std::size_t offset, std::span<const std::byte> bytes) {
  const auto write_some = [this](std::span<const std::byte> rest, off_t at) {
    return ::pwrite(file_.get(), rest.data(), rest.size(), at);
  };
  if (move_all(bytes, offset, write_some)) return {};
  return fail(ErrorCode::kCannotWrite, "%s can't be written: %s", what_, reason("the storage is full"));
}

Status JournalFile::sync() {
  if (::fdatasync(file_.get()) != 0) {
    return fail(ErrorCode::kCannotWrite, "%s can't be written: %s", what_, std::strerror(errno));
  }
  // So that the next read comes from the medium. A file system that is itself in memory may ignore it.
  static_cast<void>(::posix_fadvise(file_.get(), 0, 0, POSIX_FADV_DONTNEED));
  return {};
}

}  // namespace plumbline::firmware
