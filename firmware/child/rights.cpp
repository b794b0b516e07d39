#include "firmware/child/rights.hpp"

#include <fcntl.h>
#include <linux/audit.h>
#include <linux/capability.h>
#include <linux/filter.h>
#include <linux/landlock.h>
#include <linux/seccomp.h>
#include <sys/prctl.h>
#include <sys/syscall.h>
#include <unistd.h>

#include <algorithm>
#include <array>
#include <cerrno>
#include <cstddef>
#include <cstring>

#if defined(__has_feature)
#if __has_feature(address_sanitizer) || __has_feature(thread_sanitizer)
#define PLUMBLINE_HAS_SANITIZER
#endif
#endif
#if defined(__SANITIZE_ADDRESS__) || defined(__SANITIZE_THREAD__)
#define PLUMBLINE_HAS_SANITIZER
#endif

namespace plumbline {
namespace {

tl::unexpected<Error> lacks(const char* what) {
  return fail(ErrorCode::kUnsupported, "a process can't be kept apart on this kernel: %s: %s", what,
              std::strerror(errno));
}

bool drop_capabilities() {
  __user_cap_header_struct head{};
  head.version = _LINUX_CAPABILITY_VERSION_3;
  const std::array<__user_cap_data_struct, _LINUX_CAPABILITY_U32S_3> none{};
  return ::prctl(PR_SET_NO_NEW_PRIVS, 1, 0, 0, 0) == 0 &&
         ::prctl(PR_CAP_AMBIENT, PR_CAP_AMBIENT_CLEAR_ALL, 0, 0, 0) == 0 &&
         ::syscall(SYS_capset, &head, none.data()) == 0;
}

#if defined(PLUMBLINE_HAS_SANITIZER) && defined(__clang__)
constexpr std::array kOpenMpFolders = {"/dev/shm", "/usr/lib"};

/// clang's OpenMP run time registers itself in shared memory after a fork, and aborts where it can't. Then it loads a library that
/// tells ThreadSanitizer what its threads wait for.
bool allow_openmp(int rules, std::uint64_t rights) {
  return std::all_of(kOpenMpFolders.begin(), kOpenMpFolders.end(), [&](const char* folder) {
    landlock_path_beneath_attr shared{};
    shared.allowed_access = rights;
    shared.parent_fd = ::open(folder, O_PATH | O_CLOEXEC);
    if (shared.parent_fd < 0) return true;
    const bool added = ::syscall(SYS_landlock_add_rule, rules, LANDLOCK_RULE_PATH_BENEATH, &shared, 0) == 0;
    ::close(shared.parent_fd);
    return added;
  });
}
#else
bool allow_openmp(int /*rules*/, std::uint64_t /*rights*/) { return true; }
#endif

/// Landlock without any rule: nothing is allowed.
/// @returns false: the kernel lacks it
Expected<bool> deny_files() {
  const long version = ::syscall(SYS_landlock_create_ruleset, nullptr, 0, LANDLOCK_CREATE_RULESET_VERSION);
  if (version < 1) return false;
  // Header files older than the kernel know only some of it: struct landlock_ruleset_attr, its rights by version, and its size.
  struct Denied {
    std::uint64_t files, network, scopes;
  };
  constexpr std::array<unsigned, 6> kFileRights = {0, 13, 14, 15, 15, 16};
  const auto rights = kFileRights[static_cast<std::size_t>(std::min(version, 5L))];
  const Denied denied{(std::uint64_t{1} << rights) - 1, version >= 4 ? 3U : 0U, version >= 6 ? 3U : 0U};
  const std::size_t size = version >= 6 ? sizeof denied : version >= 4 ? 2 * sizeof denied.files : sizeof denied.files;
  const long rules = ::syscall(SYS_landlock_create_ruleset, &denied, size, 0);
  if (rules < 0 || !allow_openmp(static_cast<int>(rules), denied.files) ||
      ::syscall(SYS_landlock_restrict_self, rules, 0) != 0) {
    return lacks("Landlock");
  }
  ::close(static_cast<int>(rules));
  return true;
}

/// Without /proc this stays as it is.
void die_first() {
  const int file = ::open("/proc/self/oom_score_adj", O_WRONLY | O_CLOEXEC);
  if (file < 0) return;
  static_cast<void>(!::write(file, "800", 3));
  ::close(file);
}

#ifndef PLUMBLINE_HAS_SANITIZER
#if defined(__x86_64__)
constexpr std::uint32_t kMachine = AUDIT_ARCH_X86_64;
#elif defined(__aarch64__)
constexpr std::uint32_t kMachine = AUDIT_ARCH_AARCH64;
#elif defined(__arm__)
constexpr std::uint32_t kMachine = AUDIT_ARCH_ARM;
#elif defined(__riscv) && __riscv_xlen == 64
constexpr std::uint32_t kMachine = AUDIT_ARCH_RISCV64;
#else
#error "give the machine its AUDIT_ARCH_ of linux/audit.h"
#endif

struct Rule {
  long call;
  std::uint32_t action;
};

constexpr std::uint32_t kNoMemory = SECCOMP_RET_ERRNO | ENOMEM;
constexpr std::uint32_t kNotPermitted = SECCOMP_RET_ERRNO | EPERM;

constexpr Rule kRules[] = {
    // Reading the scan, waiting for other threads, the time, the end.
    {SYS_read, SECCOMP_RET_ALLOW},
#ifdef SYS_lseek
    {SYS_lseek, SECCOMP_RET_ALLOW},
#endif
#ifdef SYS__llseek
    {SYS__llseek, SECCOMP_RET_ALLOW},
#endif
    {SYS_futex, SECCOMP_RET_ALLOW},
    {SYS_sched_yield, SECCOMP_RET_ALLOW},
    {SYS_clock_gettime, SECCOMP_RET_ALLOW},
    {SYS_exit, SECCOMP_RET_ALLOW},
    {SYS_exit_group, SECCOMP_RET_ALLOW},
    {SYS_rt_sigreturn, SECCOMP_RET_ALLOW},
    {SYS_rt_sigprocmask, SECCOMP_RET_ALLOW},
    {SYS_restart_syscall, SECCOMP_RET_ALLOW},
#ifdef SYS_futex_time64
    {SYS_futex_time64, SECCOMP_RET_ALLOW},
#endif
#ifdef SYS_clock_gettime64
    {SYS_clock_gettime64, SECCOMP_RET_ALLOW},
#endif
    // All memory was taken before. The C library handles the error.
    {SYS_brk, kNoMemory},
#ifdef SYS_mmap
    {SYS_mmap, kNoMemory},
#endif
#ifdef SYS_mmap2
    {SYS_mmap2, kNoMemory},
#endif
    {SYS_mremap, kNoMemory},
    // abort() tries these and then ends the process anyway: SIGABRT says more than SIGSYS.
    {SYS_getpid, SECCOMP_RET_ALLOW},
    {SYS_gettid, SECCOMP_RET_ALLOW},
    {SYS_tgkill, kNotPermitted},
    {SYS_write, kNotPermitted},
    {SYS_writev, kNotPermitted},
};
#endif  // PLUMBLINE_HAS_SANITIZER

}  // namespace

Expected<bool> give_up_files() {
  if (::prctl(PR_SET_DUMPABLE, 0, 0, 0, 0) != 0) return lacks("PR_SET_DUMPABLE");
  if (!drop_capabilities()) return lacks("capabilities");
  return deny_files();
}

Expected<bool> give_up_rights(int kept) {
  die_first();
  if (kept != kKeptDescriptor && ::dup3(kept, kKeptDescriptor, O_CLOEXEC) < 0) return lacks("dup3");
  for (int file = 0; file < kKeptDescriptor; ++file) ::close(file);
  if (::syscall(SYS_close_range, kKeptDescriptor + 1, ~0U, 0) != 0) return lacks("close_range");
  return give_up_files();
}

#ifdef PLUMBLINE_HAS_SANITIZER
// A sanitizer takes memory and writes reports whenever it likes.
bool filter_system_calls() { return true; }
bool filter_system_calls(std::span<const CallRule> /*allowed*/) { return true; }
#else
namespace {

/// A filter under construction. The first instructions check the machine and load the call's number.
class Filter {
 public:
  static constexpr std::size_t kMost = 512;

  Filter() {
    load(offsetof(seccomp_data, arch));
    add(BPF_JUMP(BPF_JMP | BPF_JEQ | BPF_K, kMachine, 1, 0));
    end(SECCOMP_RET_KILL_PROCESS);
    load(offsetof(seccomp_data, nr));
  }
  void add(sock_filter instruction) {
    if (size_ < kMost) program_[size_] = instruction;
    ++size_;
  }
  void load(std::size_t offset) { add(BPF_STMT(BPF_LD | BPF_W | BPF_ABS, static_cast<std::uint32_t>(offset))); }
  void end(std::uint32_t action) { add(BPF_STMT(BPF_RET | BPF_K, action)); }
  /// Runs the next `instructions` only for a call.
  void when(long call, std::uint8_t instructions) {
    add(BPF_JUMP(BPF_JMP | BPF_JEQ | BPF_K, static_cast<std::uint32_t>(call), 0, instructions));
  }
  bool install() {
    if (size_ > kMost) return false;
    sock_fprog filter{};
    filter.len = static_cast<unsigned short>(size_);
    filter.filter = program_.data();
    return ::syscall(SYS_seccomp, SECCOMP_SET_MODE_FILTER, SECCOMP_FILTER_FLAG_TSYNC, &filter) == 0;
  }

 private:
  std::array<sock_filter, kMost> program_{};
  std::size_t size_ = 0;
};

}  // namespace

bool filter_system_calls() {
  Filter filter;
  for (const Rule& rule : kRules) {
    filter.when(rule.call, 1);
    filter.end(rule.action);
  }
  filter.end(SECCOMP_RET_KILL_PROCESS);
  return filter.install();
}

bool filter_system_calls(std::span<const CallRule> allowed) {
  Filter filter;
  for (const CallRule& rule : allowed) {
    if (rule.when.argument < 0) {
      filter.when(rule.call, 1);
      filter.end(SECCOMP_RET_ALLOW);
      continue;
    }
    filter.when(rule.call, 5);
    // The low half: all machines above are little-endian.
    filter.load(offsetof(seccomp_data, args) + sizeof(std::uint64_t) * static_cast<std::size_t>(rule.when.argument));
    filter.add(BPF_STMT(BPF_ALU | BPF_AND | BPF_K, rule.when.mask));
    filter.add(BPF_JUMP(BPF_JMP | BPF_JEQ | BPF_K, rule.when.value, 0, 1));
    filter.end(SECCOMP_RET_ALLOW);
    filter.end(kNotPermitted);
  }
  filter.end(kNotPermitted);
  return filter.install();
}
#endif  // PLUMBLINE_HAS_SANITIZER

}  // namespace plumbline
