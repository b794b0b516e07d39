#include "firmware/archive/zip_calls.hpp"

#include <unistd.h>

#include <algorithm>
#include <cerrno>
#include <cstddef>
#include <cstdint>
#include <limits>

namespace plumbline::firmware::inline archive {
namespace {

ZipHandle& handle_of(voidpf opaque) { return *static_cast<ZipHandle*>(opaque); }

void note(ZipHandle& handle) {
  if (handle.reason == 0) handle.reason = errno;
}

voidpf open_it(voidpf opaque, const void* /*name*/, int /*mode*/) { return opaque; }

uLong read_it(voidpf opaque, voidpf /*stream*/, void* to, uLong size) {
  ZipHandle& handle = handle_of(opaque);
  if (handle.file < 0) {
    const auto at = static_cast<std::size_t>(std::min<std::uint64_t>(handle.at, handle.memory.size()));
    const auto part = handle.memory.subspan(at, std::min<std::size_t>(size, handle.memory.size() - at));
    std::copy(part.begin(), part.end(), static_cast<std::byte*>(to));
    handle.at += part.size();
    return static_cast<uLong>(part.size());
  }
  uLong filled = 0;
  while (filled < size) {
    const ssize_t got = ::read(handle.file, static_cast<std::byte*>(to) + filled, size - filled);
    if (got < 0 && errno == EINTR) continue;
    if (got < 0) note(handle);
    if (got <= 0) break;
    filled += static_cast<uLong>(got);
  }
  return filled;
}

uLong write_it(voidpf opaque, voidpf /*stream*/, const void* from, uLong size) {
  ZipHandle& handle = handle_of(opaque);
  uLong written = 0;
  while (written < size) {
    const ssize_t put = ::write(handle.file, static_cast<const std::byte*>(from) + written, size - written);
    if (put < 0 && errno == EINTR) continue;
    if (put < 0) {
      note(handle);
      break;
    }
    written += static_cast<uLong>(put);
  }
  return written;
}

ZPOS64_T tell_it(voidpf opaque, voidpf /*stream*/) {
  ZipHandle& handle = handle_of(opaque);
  if (handle.file < 0) return handle.at;
  const off_t at = ::lseek(handle.file, 0, SEEK_CUR);
  if (at < 0) note(handle);
  return static_cast<ZPOS64_T>(std::max<off_t>(at, 0));
}

long seek_it(voidpf opaque, voidpf /*stream*/, ZPOS64_T offset, int origin) {
  ZipHandle& handle = handle_of(opaque);
  if (handle.file < 0) {
    const std::uint64_t size = handle.memory.size();
    const auto from = origin == ZLIB_FILEFUNC_SEEK_SET ? 0 : origin == ZLIB_FILEFUNC_SEEK_CUR ? handle.at : size;
    constexpr std::uint64_t kFarthest = std::numeric_limits<std::int64_t>::max();
    if (offset > kFarthest - from) return -1;
    handle.at = from + offset;  // behind the end, too, as lseek() allows: nothing is read there
    return 0;
  }
  const int from = origin == ZLIB_FILEFUNC_SEEK_SET ? SEEK_SET : origin == ZLIB_FILEFUNC_SEEK_CUR ? SEEK_CUR : SEEK_END;
  if (::lseek(handle.file, static_cast<off_t>(offset), from) >= 0) return 0;
  if (errno != EINVAL) note(handle);  // a place that an archive made up
  return -1;
}

int close_it(voidpf /*opaque*/, voidpf /*stream*/) { return 0; }

int error_of(voidpf opaque, voidpf /*stream*/) { return handle_of(opaque).reason; }

}  // namespace

zlib_filefunc64_def zip_calls(ZipHandle& handle) {
  return {open_it, read_it, write_it, tell_it, seek_it, close_it, error_of, &handle};
}

}  // namespace plumbline::firmware::inline archive
