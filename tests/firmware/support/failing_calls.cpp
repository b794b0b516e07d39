#include "tests/firmware/support/failing_calls.hpp"

#include <fcntl.h>
#include <sys/stat.h>
#include <sys/types.h>
#include <unistd.h>

#include <algorithm>
#include <atomic>
#include <cerrno>
#include <csignal>
#include <cstdarg>
#include <cstddef>
#include <map>
#include <set>

namespace plumbline::firmware {
namespace {

struct Plan {
  bool armed = false;
  Calls calls = Calls::kReads;
  Failure failure = Failure::kIoError;
  std::uint32_t nth = 0;
} plan;
std::atomic<std::uint32_t> count{0};

/// By inode: a descriptor of its own.
std::map<ino_t, int> changed;

ino_t inode_of(int file) {
  struct stat facts {};
  return ::fstat(file, &facts) == 0 ? facts.st_ino : 0;
}

void note_change(int file) {
  if (!plan.armed || plan.failure != Failure::kPowerCut || file <= STDERR_FILENO) return;
  if (const auto [place, is_new] = changed.try_emplace(inode_of(file), -1); is_new) place->second = ::dup(file);
}

/// Folders in which a name has come or gone, by inode.
std::set<ino_t> folders;

void note_name(int folder) {
  if (plan.armed && plan.failure == Failure::kPowerCut) folders.insert(inode_of(folder));
}

int note_durable(int file, int result) {
  if (result != 0) return result;
  changed.erase(inode_of(file));
  folders.erase(inode_of(file));
  return result;
}

void die() {
  for (const auto& [inode, file] : changed) {
    struct stat facts {};
    const bool lost = ::fstat(file, &facts) == 0 && S_ISREG(facts.st_mode) && ::ftruncate(file, 0) == 0;
    if (lost && ::ftruncate(file, facts.st_size) != 0) ::_exit(1);
  }
  ::raise(SIGKILL);
}

/// What to do with a call.
enum class Verdict : std::uint8_t { kPass, kFail, kHalf, kHalfAndDie };

Verdict judge(Calls calls, int file) {
  if (!plan.armed || (calls != plan.calls && plan.calls != Calls::kAll) || file <= STDERR_FILENO) return Verdict::kPass;
  const std::uint32_t number = ++count;
  if (plan.failure == Failure::kShort && calls == Calls::kWrites && number == plan.nth + 1 && plan.nth > 0) {
    errno = ENOSPC;
    return Verdict::kFail;
  }
  const bool stays_full = plan.failure == Failure::kStaysFull && plan.nth > 0 && number > plan.nth;
  if (number != plan.nth && !stays_full) return Verdict::kPass;
  if (plan.failure == Failure::kKilled || plan.failure == Failure::kPowerCut) {
    if (calls == Calls::kWrites) return Verdict::kHalfAndDie;
    die();
  }
  if (plan.failure == Failure::kShort || plan.failure == Failure::kCutInHalf) return Verdict::kHalf;
  errno = plan.failure == Failure::kDiskFull || plan.failure == Failure::kStaysFull ? ENOSPC : EIO;
  return Verdict::kFail;
}

/// @param call  takes the number of bytes
template <class Call>
ssize_t transfer(Calls calls, int file, std::size_t bytes, Call call) {
  if (calls == Calls::kWrites) note_change(file);
  switch (judge(calls, file)) {
    case Verdict::kPass: break;
    case Verdict::kHalfAndDie:
      static_cast<void>(call(bytes / 2));
      die();
      break;
    case Verdict::kFail: return -1;
    case Verdict::kHalf: bytes = std::max<std::size_t>(bytes / 2, 1); break;
  }
  return call(bytes);
}

bool fails(int file = STDERR_FILENO + 1) { return judge(Calls::kFiles, file) != Verdict::kPass; }

bool writes(int flags) { return (flags & O_ACCMODE) != O_RDONLY; }

mode_t mode_in(int flags, va_list args) {
  return (flags & O_CREAT) != 0 ? static_cast<mode_t>(va_arg(args, unsigned)) : mode_t{0};
}

}  // namespace

FailingCall::FailingCall(Calls calls, std::uint32_t nth, Failure failure) {
  count = 0;
  changed.clear();
  folders.clear();
  plan = {.armed = true, .calls = calls, .failure = failure, .nth = nth};
}
FailingCall::~FailingCall() { plan.armed = false; }
bool FailingCall::happened() const { return count >= plan.nth; }

std::size_t not_durable() { return changed.size(); }
std::size_t names_not_durable() { return folders.size(); }

}  // namespace plumbline::firmware

// The linker lets the code under test call __wrap_NAME instead of NAME, and __real_NAME is NAME.
// NOLINTBEGIN(bugprone-reserved-identifier,cert-dcl37-c,cert-dcl51-cpp)
extern "C" {
ssize_t __real_read(int, void*, std::size_t);
ssize_t __real_pread(int, void*, std::size_t, off_t);
ssize_t __real_write(int, const void*, std::size_t);
ssize_t __real_pwrite(int, const void*, std::size_t, off_t);
int __real_open(const char*, int, ...);
int __real_openat(int, const char*, int, ...);
int __real_fsync(int);
int __real_fdatasync(int);
int __real_rename(const char*, const char*);
int __real_renameat(int, const char*, int, const char*);
int __real_unlinkat(int, const char*, int);
int __real_close(int);

using plumbline::firmware::Calls;

ssize_t __wrap_read(int file, void* to, std::size_t bytes) {
  return plumbline::firmware::transfer(Calls::kReads, file, bytes,
                                       [=](std::size_t n) { return __real_read(file, to, n); });
}
ssize_t __wrap_pread(int file, void* to, std::size_t bytes, off_t at) {
  return plumbline::firmware::transfer(Calls::kReads, file, bytes,
                                       [=](std::size_t n) { return __real_pread(file, to, n, at); });
}
ssize_t __wrap_write(int file, const void* from, std::size_t bytes) {
  return plumbline::firmware::transfer(Calls::kWrites, file, bytes,
                                       [=](std::size_t n) { return __real_write(file, from, n); });
}
ssize_t __wrap_pwrite(int file, const void* from, std::size_t bytes, off_t at) {
  return plumbline::firmware::transfer(Calls::kWrites, file, bytes,
                                       [=](std::size_t n) { return __real_pwrite(file, from, n, at); });
}
int __wrap_open(const char* path, int flags, ...) {
  va_list args;
  va_start(args, flags);
  const mode_t mode = plumbline::firmware::mode_in(flags, args);
  va_end(args);
  return plumbline::firmware::writes(flags) && plumbline::firmware::fails() ? -1 : __real_open(path, flags, mode);
}
int __wrap_openat(int folder, const char* path, int flags, ...) {
  va_list args;
  va_start(args, flags);
  const mode_t mode = plumbline::firmware::mode_in(flags, args);
  va_end(args);
  if (plumbline::firmware::writes(flags) && plumbline::firmware::fails()) return -1;
  if ((flags & O_CREAT) != 0 && ::faccessat(folder, path, F_OK, AT_SYMLINK_NOFOLLOW) != 0)
    plumbline::firmware::note_name(folder);
  return __real_openat(folder, path, flags, mode);
}
int __wrap_fsync(int file) {
  return plumbline::firmware::fails(file) ? -1 : plumbline::firmware::note_durable(file, __real_fsync(file));
}
int __wrap_fdatasync(int file) {
  return plumbline::firmware::fails(file) ? -1 : plumbline::firmware::note_durable(file, __real_fdatasync(file));
}
int __wrap_rename(const char* from, const char* to) {
  return plumbline::firmware::fails() ? -1 : __real_rename(from, to);
}
int __wrap_renameat(int folder, const char* from, int to_folder, const char* to) {
  if (plumbline::firmware::fails()) return -1;
  plumbline::firmware::note_change(to_folder);
  return __real_renameat(folder, from, to_folder, to);
}
int __wrap_unlinkat(int folder, const char* path, int flags) {
  if (plumbline::firmware::judge(Calls::kRemovals, folder) != plumbline::firmware::Verdict::kPass) return -1;
  const int removed = __real_unlinkat(folder, path, flags);
  const int reason = errno;
  if (removed == 0) plumbline::firmware::note_name(folder);
  errno = reason;
  return removed;
}
int __wrap_close(int file) {
  const bool failed = plumbline::firmware::fails(file);
  const int reason = errno;
  const int closed = __real_close(file);
  if (!failed) return closed;
  errno = reason;
  return -1;
}
}
// NOLINTEND(bugprone-reserved-identifier,cert-dcl37-c,cert-dcl51-cpp)
