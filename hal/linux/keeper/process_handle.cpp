#include "hal/linux/keeper/process_handle.hpp"

#include <poll.h>
#include <sys/syscall.h>
#include <unistd.h>

#include <csignal>

namespace plumbline::inline hal::inline linux_board {

// By number: C libraries older than Debian 12's lack the functions.
ProcessHandle::ProcessHandle(pid_t process) : file_(static_cast<int>(::syscall(SYS_pidfd_open, process, 0))) {}

ProcessHandle::~ProcessHandle() {
  if (file_ >= 0) ::close(file_);
}

void ProcessHandle::kill() const { static_cast<void>(::syscall(SYS_pidfd_send_signal, file_, SIGKILL, nullptr, 0)); }

bool ProcessHandle::await_end(std::chrono::milliseconds time) const {
  pollfd fd{file_, POLLIN, 0};
  return ::poll(&fd, 1, static_cast<int>(time.count())) == 1;
}

}  // namespace plumbline::inline hal::inline linux_board
