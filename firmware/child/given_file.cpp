#include "firmware/child/given_file.hpp"

#include <unistd.h>

#include <cerrno>
#include <cstring>

#include "firmware/messages/printer_code.hpp"

namespace plumbline::firmware {

Expected<std::size_t> GivenFile::read(std::span<std::byte> buffer) {
  for (;;) {
    const ssize_t got = ::read(descriptor_, buffer.data(), buffer.size());
    if (got >= 0) return static_cast<std::size_t>(got);
    if (errno == EINTR) continue;
    return telling(Told(PrinterCode::kBadSectors),
                   fail(ErrorCode::kCannotRead,
                        "%s: %s: the stick has bad sectors or a damaged file system:\tcopy the file to another stick",
                        file_.name.c_str(), std::strerror(errno)));
  }
}

Status GivenFile::rewind() {
  if (::lseek(descriptor_, 0, SEEK_SET) != 0) return ByteSource::rewind();
  return {};
}

}  // namespace plumbline::firmware
