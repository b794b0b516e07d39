#include "hal/process/report_folder.hpp"

#include <fcntl.h>
#include <sys/stat.h>
#include <unistd.h>

#include <algorithm>
#include <array>
#include <cctype>
#include <cerrno>
#include <cstddef>
#include <cstdio>

namespace plumbline::inline hal {
namespace {

constexpr const char* kUnfinished = "unfinished";

/// @returns errno
int copy_bytes(int from, int to, std::uint64_t at, std::uint64_t bytes) {
  std::array<std::byte, 16384> block;  // NOLINT(cppcoreguidelines-pro-type-member-init)
  for (std::uint64_t end = at + bytes; at < end;) {
    const auto wanted = static_cast<std::size_t>(std::min<std::uint64_t>(block.size(), end - at));
    const ssize_t got = ::pread(from, block.data(), wanted, static_cast<off_t>(at));
    if (got < 0 && errno == EINTR) continue;
    if (got <= 0) return got < 0 ? errno : EIO;
    for (ssize_t done = 0; done < got;) {
      const ssize_t written = ::write(to, block.data() + done, static_cast<std::size_t>(got - done));
      if (written < 0 && errno == EINTR) continue;
      if (written <= 0) return written < 0 ? errno : ENOSPC;
      done += written;
    }
    at += static_cast<std::uint64_t>(got);
  }
  return ::fsync(to) == 0 ? 0 : errno;
}

int copy_into(int folder, const char* name, int file, std::uint64_t from, std::uint64_t bytes) {
  struct stat facts {};
  if (::fstatat(folder, name, &facts, AT_SYMLINK_NOFOLLOW) == 0) return EEXIST;
  if (errno != ENOENT) return errno;
  if (::unlinkat(folder, kUnfinished, 0) != 0 && errno != ENOENT) return errno;
  const int out = ::openat(folder, kUnfinished, O_WRONLY | O_CREAT | O_EXCL | O_NOFOLLOW | O_CLOEXEC, 0644);
  if (out < 0) return errno;
  int reason = copy_bytes(file, out, from, bytes);
  if (::close(out) != 0 && reason == 0) reason = errno;
  if (reason == 0 && ::renameat2(folder, kUnfinished, folder, name, RENAME_NOREPLACE) != 0) reason = errno;
  if (reason != 0) {
    ::unlinkat(folder, kUnfinished, 0);
    return reason;
  }
  return ::syncfs(folder) == 0 ? 0 : errno;
}

}  // namespace

bool is_report_name(std::string_view name) {
  const auto plain = [](unsigned char c) { return std::isalnum(c) != 0 || c == '.' || c == '-' || c == '_'; };
  return !name.empty() && name.size() < kReportNameBytes && name.front() != '.' &&
         std::all_of(name.begin(), name.end(), plain);
}

int copy_report(int top, std::string_view name, int file, std::uint64_t from, std::uint64_t bytes) {
  if (!is_report_name(name)) return EINVAL;
  const int folder = ::openat(top, kReportFolder, O_RDONLY | O_DIRECTORY | O_NOFOLLOW | O_CLOEXEC);
  if (folder < 0) return errno;
  std::array<char, kReportNameBytes> text{};
  std::copy(name.begin(), name.end(), text.begin());
  const int reason = copy_into(folder, text.data(), file, from, bytes);
  ::close(folder);
  return reason;
}

}  // namespace plumbline::inline hal
