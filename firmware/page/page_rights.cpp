#include "firmware/page/page_rights.hpp"

#include <fcntl.h>
#include <sys/socket.h>
#include <sys/syscall.h>

#include <array>

#include "firmware/child/rights.hpp"

namespace plumbline {
namespace {

constexpr CallRule kRules[] = {
    // Connections and events.
    {SYS_epoll_ctl},
    {SYS_epoll_pwait},
#ifdef SYS_epoll_wait
    {SYS_epoll_wait},
#endif
#ifdef SYS_poll
    {SYS_poll},
#endif
    {SYS_ppoll},
#ifdef SYS_ppoll_time64
    {SYS_ppoll_time64},
#endif
    {SYS_accept4},
    {SYS_getsockopt},
    {SYS_setsockopt},
    {SYS_getsockname},
    {SYS_getpeername},
    {SYS_shutdown},
    {SYS_close},
    {SYS_fcntl},
#ifdef SYS_fcntl64
    {SYS_fcntl64},
#endif
#ifdef SYS_recv
    {SYS_recv},
    {SYS_send},
#endif
    {SYS_recvfrom},
    {SYS_sendto},
    {SYS_sendmsg},
    {SYS_read},
    {SYS_write},
    {SYS_writev},
    // The file of paired browsers, which is open.
    {SYS_pwrite64},
    // The state socket, again when the printer's daemon has started again. Its folder is opened as a place, not for reading.
    {SYS_socket, {.argument = 0, .mask = ~0U, .value = AF_UNIX}},
    {SYS_connect},
    // Through which a scan goes to the printer.
    {SYS_socketpair, {.argument = 0, .mask = ~0U, .value = AF_UNIX}},
    {SYS_openat, {.argument = 2, .mask = O_PATH, .value = O_PATH}},
#ifdef SYS_open
    {SYS_open, {.argument = 1, .mask = O_PATH, .value = O_PATH}},
#endif
    // Memory, whose use is bounded, random numbers, time, the end.
    {SYS_brk},
#ifdef SYS_mmap
    {SYS_mmap},
#endif
#ifdef SYS_mmap2
    {SYS_mmap2},
#endif
    {SYS_munmap},
    {SYS_mremap},
    {SYS_madvise},
    {SYS_getrandom},
    {SYS_clock_gettime},
#ifdef SYS_clock_gettime64
    {SYS_clock_gettime64},
#endif
    {SYS_gettimeofday},
    {SYS_futex},
#ifdef SYS_futex_time64
    {SYS_futex_time64},
#endif
    {SYS_rt_sigreturn},
    {SYS_rt_sigprocmask},
    {SYS_restart_syscall},
    {SYS_exit},
    {SYS_exit_group},
    {SYS_getpid},
    {SYS_gettid},
};

}  // namespace

Status give_up_page_rights() {
  PLUMBLINE_TRY(give_up_files());
  if (!filter_system_calls(kRules)) {
    return fail(ErrorCode::kUnsupported, "the page can't be kept apart on this kernel: it has no seccomp filters");
  }
  return {};
}

}  // namespace plumbline
