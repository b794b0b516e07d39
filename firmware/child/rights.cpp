#include "firmware/child/rights.hpp"

#include <fcntl.h>
#include <linux/capability.h>
#include <linux/landlock.h>
#include <seccomp.h>
#include <sys/prctl.h>
#include <sys/syscall.h>
#include <unistd.h>

#include <algorithm>
#include <array>
#include <cerrno>
#include <cstring>
#include <memory>

#if defined(__has_feature)
#if __has_feature(address_sanitizer) || __has_feature(thread_sanitizer)
#define PLUMBLINE_HAS_SANITIZER
#endif
#endif
#if defined(__SANITIZE_ADDRESS__) || defined(__SANITIZE_THREAD__)
#define PLUMBLINE_HAS_SANITIZER
#endif

namespace plumbline::firmware {
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
struct ReleaseFilter {
  void operator()(void* filter) const { seccomp_release(filter); }
};

/// Builds a filter on the heap. A call by the numbers of another architecture kills the process.
class Filter {
 public:
  explicit Filter(std::uint32_t otherwise) : filter_(seccomp_init(otherwise)) {
    good_ = filter_ != nullptr &&
            seccomp_attr_set(filter_.get(), SCMP_FLTATR_ACT_BADARCH, SCMP_ACT_KILL_PROCESS) == 0 &&
            seccomp_attr_set(filter_.get(), SCMP_FLTATR_CTL_TSYNC, 1) == 0;
  }
  /// A call that this machine lacks is left out; a name that no machine has is an error of ours.
  void add(std::uint32_t action, const CallRule& rule) {
    const int call = seccomp_syscall_resolve_name(rule.call);
    if (call == __NR_SCMP_ERROR) good_ = false;
    if (call < 0 || !good_) return;
    const unsigned conditions = rule.when.argument < 0 ? 0 : 1;
    const scmp_arg_cmp when{static_cast<unsigned>(std::max(rule.when.argument, 0)), SCMP_CMP_MASKED_EQ, rule.when.mask,
                            rule.when.value};
    good_ = seccomp_rule_add_array(filter_.get(), action, call, conditions, &when) == 0;
  }
  bool install() const { return good_ && seccomp_load(filter_.get()) == 0; }

 private:
  std::unique_ptr<void, ReleaseFilter> filter_;
  bool good_ = false;
};

// Reading the scan, waiting for other threads, the time, the end. abort() asks who it is.
constexpr CallRule kAllowed[] = {
    {"read"},         {"lseek"},          {"_llseek"},         {"futex"},  {"futex_time64"},
    {"sched_yield"},  {"clock_gettime"},  {"clock_gettime64"}, {"exit"},   {"exit_group"},
    {"rt_sigreturn"}, {"rt_sigprocmask"}, {"restart_syscall"}, {"getpid"}, {"gettid"},
};
// All memory was taken before. The C library handles the error.
constexpr CallRule kMemory[] = {{"brk"}, {"mmap"}, {"mmap2"}, {"mremap"}};
// abort() tries these and then ends the process anyway: SIGABRT says more than SIGSYS.
constexpr CallRule kOfAbort[] = {{"tgkill"}, {"write"}, {"writev"}};
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
bool filter_system_calls() {
  Filter filter(SCMP_ACT_KILL_PROCESS);
  for (const CallRule& rule : kAllowed) filter.add(SCMP_ACT_ALLOW, rule);
  for (const CallRule& rule : kMemory) filter.add(SCMP_ACT_ERRNO(ENOMEM), rule);
  for (const CallRule& rule : kOfAbort) filter.add(SCMP_ACT_ERRNO(EPERM), rule);
  return filter.install();
}

bool filter_system_calls(std::span<const CallRule> allowed) {
  Filter filter(SCMP_ACT_ERRNO(EPERM));
  for (const CallRule& rule : allowed) filter.add(SCMP_ACT_ALLOW, rule);
  return filter.install();
}
#endif  // PLUMBLINE_HAS_SANITIZER

}  // namespace plumbline::firmware
