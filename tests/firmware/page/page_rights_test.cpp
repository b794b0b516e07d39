#include "firmware/page/page_rights.hpp"

#include <fcntl.h>
#include <gtest/gtest.h>
#include <linux/landlock.h>
#include <linux/sched.h>
#include <sys/mount.h>
#include <sys/prctl.h>
#include <sys/socket.h>
#include <sys/syscall.h>
#include <sys/wait.h>
#include <unistd.h>

#include <cerrno>
#include <csignal>
#include <functional>
#include <string>

#include "tests/firmware/child/child_fixture.hpp"

namespace plumbline::firmware {
namespace {

/// What one call returns in a process that has given up the page's rights: 0 or errno.
int errno_of(const std::function<long()>& call) {
  const pid_t process = ::fork();
  if (process == 0) {
    if (!give_up_page_rights()) ::_exit(200);
    errno = 0;
    const long result = call();
    ::_exit(result < 0 ? errno : 0);
  }
  int status = 0;
  ::waitpid(process, &status, 0);
  EXPECT_TRUE(WIFEXITED(status)) << "killed by " << WTERMSIG(status);
  return WEXITSTATUS(status);
}

class PageRights : public testing::Test {
 protected:
  void SetUp() override {
    if (kHasSanitizer) GTEST_SKIP() << "system calls are not filtered";
  }
};

// Landlock says EACCES, so EPERM shows that the filter holds by itself, on kernels without Landlock, too.
TEST_F(PageRights, OpenNoFileInAnyWay) {
  for (const int flags : {O_RDONLY, O_WRONLY, O_RDWR, O_RDONLY | O_CLOEXEC, O_WRONLY | O_CREAT, O_RDONLY | O_DIRECTORY,
                          O_RDWR | O_TMPFILE, O_RDONLY | O_NOFOLLOW}) {
    EXPECT_EQ(errno_of([flags] { return ::syscall(SYS_openat, AT_FDCWD, "/proc/self/status", flags, 0600); }), EPERM)
        << flags;
#ifdef SYS_open
    EXPECT_EQ(errno_of([flags] { return ::syscall(SYS_open, "/proc/self/status", flags, 0600); }), EPERM) << flags;
#endif
  }
  EXPECT_EQ(errno_of([] { return ::syscall(SYS_openat, AT_FDCWD, "/", O_PATH | O_CLOEXEC, 0); }), 0) << "a place";
#ifdef SYS_openat2
  EXPECT_EQ(errno_of([] {
              std::array<std::uint64_t, 3> how = {};
              return ::syscall(SYS_openat2, AT_FDCWD, "/proc/self/status", how.data(), sizeof how);
            }),
            EPERM);
#endif
}

TEST_F(PageRights, MakeNoSocketButUnixOnes) {
  EXPECT_EQ(errno_of([] { return ::socket(AF_UNIX, SOCK_STREAM | SOCK_CLOEXEC, 0); }), 0);
  for (const int domain : {AF_INET, AF_INET6, AF_NETLINK, AF_PACKET, AF_VSOCK}) {
    for (const int type : {SOCK_STREAM, SOCK_DGRAM, SOCK_RAW}) {
      EXPECT_EQ(errno_of([=] { return ::socket(domain, type, 0); }), EPERM) << domain << " " << type;
    }
  }
  const auto pair = [](int domain) {
    return [domain] {
      std::array<int, 2> two{};
      return ::socketpair(domain, SOCK_STREAM, 0, two.data());
    };
  };
  EXPECT_EQ(errno_of(pair(AF_UNIX)), 0);
  EXPECT_EQ(errno_of(pair(AF_TIPC)), EPERM);
  EXPECT_EQ(errno_of([] { return ::bind(-1, nullptr, 0); }), EPERM);
  EXPECT_EQ(errno_of([] { return ::listen(-1, 0); }), EPERM);
}

TEST_F(PageRights, StartStopDebugAndChangeNothing) {
  EXPECT_EQ(errno_of([] { return ::execl("/bin/true", "true", nullptr); }), EPERM);
  EXPECT_EQ(errno_of([] { return ::syscall(SYS_clone, CLONE_VM, nullptr, nullptr, nullptr, nullptr); }), EPERM);
  EXPECT_EQ(errno_of([] { return ::kill(::getppid(), 0); }), EPERM);
  EXPECT_EQ(errno_of([] { return ::syscall(SYS_ptrace, 16, 1, 0, 0); }), EPERM);
  EXPECT_EQ(errno_of([] { return ::syscall(SYS_process_vm_readv, 1, nullptr, 0, nullptr, 0, 0); }), EPERM);
  EXPECT_EQ(errno_of([] { return ::unlink("/nothing"); }), EPERM);
  EXPECT_EQ(errno_of([] { return ::rename("/nothing", "/other"); }), EPERM);
  EXPECT_EQ(errno_of([] { return ::mount("none", "/nothing", "tmpfs", 0, nullptr); }), EPERM);
  EXPECT_EQ(errno_of([] { return ::syscall(SYS_ioctl, 0, 0, 0); }), EPERM);
  EXPECT_EQ(errno_of([] { return ::syscall(SYS_mprotect, nullptr, 4096, 7); }), EPERM);
}

// What lies below the filter.
TEST_F(PageRights, HaveNoCapabilityAndNoWayToGainOne) {
  std::array<int, 2> pipe{};
  ASSERT_EQ(::pipe(pipe.data()), 0);
  const pid_t process = ::fork();
  if (process == 0) {
    const int file = ::open("/proc/self/status", O_RDONLY);
    if (file < 0 || !give_up_page_rights()) ::_exit(200);
    std::array<char, 4096> text{};
    ssize_t size = ::read(file, text.data(), text.size());
    size = ::write(pipe[1], text.data(), size > 0 ? static_cast<std::size_t>(size) : 0);
    ::_exit(size > 0 ? 0 : 201);
  }
  ::close(pipe[1]);
  std::array<char, 4096> text{};
  const ssize_t size = ::read(pipe[0], text.data(), text.size());
  int ended = 0;
  ::waitpid(process, &ended, 0);
  EXPECT_EQ(ended, 0);
  const std::string seen(text.data(), size > 0 ? static_cast<std::size_t>(size) : 0);
  EXPECT_NE(seen.find("NoNewPrivs:\t1"), std::string::npos) << seen;
  EXPECT_NE(seen.find("CapPrm:\t0000000000000000"), std::string::npos) << seen;
  EXPECT_NE(seen.find("CapEff:\t0000000000000000"), std::string::npos) << seen;
  ::close(pipe[0]);
}

}  // namespace
}  // namespace plumbline::firmware
