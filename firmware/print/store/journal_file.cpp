#include "firmware/print/store/journal_file.hpp"

#include <unistd.h>

#include <cerrno>
#include <cstring>

namespace plumbline {

Status JournalFile::read(std::size_t offset, std::span<std::byte> bytes) {
  const ssize_t got = ::pread(file_.get(), bytes.data(), bytes.size(), static_cast<off_t>(offset));
  if (got == static_cast<ssize_t>(bytes.size())) return {};
  return fail(ErrorCode::kCannotRead, "the journal can't be read: %s",
              got < 0 ? std::strerror(errno) : "the file is cut off");
}

Status JournalFile::write(std::size_t offset, std::span<const std::byte> bytes) {
  const ssize_t put = ::pwrite(file_.get(), bytes.data(), bytes.size(), static_cast<off_t>(offset));
  if (put == static_cast<ssize_t>(bytes.size())) return {};
  return fail(ErrorCode::kCannotWrite, "the journal can't be written: %s",
              put < 0 ? std::strerror(errno) : "the storage is full");
}

Status JournalFile::sync() {
  if (::fdatasync(file_.get()) == 0) return {};
  return fail(ErrorCode::kCannotWrite, "the journal can't be written: %s", std::strerror(errno));
}

}  // namespace plumbline
