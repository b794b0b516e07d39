#include "firmware/page/page_rights.hpp"

#include <fcntl.h>
#include <sys/socket.h>

#include <array>

#include "firmware/child/rights.hpp"

namespace plumbline::firmware::inline page {
namespace {

constexpr CallRule kRules[] = {
    // Connections and events.
    {"epoll_ctl"},
    {"epoll_pwait"},
    {"epoll_wait"},
    {"poll"},
    {"ppoll"},
    {"ppoll_time64"},
    {"accept4"},
    {"getsockopt"},
    {"setsockopt"},
    {"getsockname"},
    {"getpeername"},
    {"shutdown"},
    {"close"},
    {"fcntl"},
    {"fcntl64"},
    {"recv"},
    {"send"},
    {"recvfrom"},
    {"sendto"},
    {"sendmsg"},
    {"read"},
    {"write"},
    {"writev"},
    // The file of paired browsers, which is open.
    {"pwrite64"},
    // The state socket, again when the printer's daemon has started again. Its folder is opened as a place, not for reading.
    {"socket", {.argument = 0, .mask = ~0U, .value = AF_UNIX}},
    {"connect"},
    // Through which a scan goes to the printer.
    {"socketpair", {.argument = 0, .mask = ~0U, .value = AF_UNIX}},
    {"openat", {.argument = 2, .mask = O_PATH, .value = O_PATH}},
    {"open", {.argument = 1, .mask = O_PATH, .value = O_PATH}},
    // Memory, whose use is bounded, random numbers, time, the end.
    {"brk"},
    {"mmap"},
    {"mmap2"},
    {"munmap"},
    {"mremap"},
    {"madvise"},
    {"getrandom"},
    {"clock_gettime"},
    {"clock_gettime64"},
    {"gettimeofday"},
    {"futex"},
    {"futex_time64"},
    {"rt_sigreturn"},
    {"rt_sigprocmask"},
    {"restart_syscall"},
    {"exit"},
    {"exit_group"},
    {"getpid"},
    {"gettid"},
};

}  // namespace

Status give_up_page_rights() {
  PLUMBLINE_TRY(give_up_files());
  if (!filter_system_calls(kRules)) {
    return fail(ErrorCode::kUnsupported, "the page can't be kept apart on this kernel: it has no seccomp filters");
  }
  return {};
}

}  // namespace plumbline::firmware::inline page
