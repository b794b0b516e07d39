#include "firmware/child/child_template.hpp"

#include <poll.h>
#include <sys/prctl.h>
#include <sys/syscall.h>
#include <sys/wait.h>
#include <unistd.h>

#include <algorithm>
#include <array>
#include <csignal>
#include <latch>
#include <span>
#include <string_view>
#include <thread>
#include <vector>

#include "firmware/child/child_protocol.hpp"
#include "firmware/child/rights.hpp"
#include "hal/process/passed_descriptor.hpp"
#include "hal/process/process_memory.hpp"

namespace plumbline::firmware {
namespace {

bool send(const ChildMessage& message) { return send_message(kKeptDescriptor, std::as_bytes(std::span(&message, 1))); }

/// Ends this process with its parent.
void end_with(pid_t parent) {
  ::prctl(PR_SET_PDEATHSIG, SIGKILL, 0, 0, 0);
  if (::getppid() != parent) ::_exit(0);
}

/// The C library keeps the stacks of ended threads, and a fork inherits them: a child then starts its threads without asking the kernel
/// for memory.
void leave_stacks(std::uint32_t threads) {
  if (threads < 2) return;
  std::latch all_started(threads);
  std::vector<std::thread> team;
  for (std::uint32_t i = 0; i < threads; ++i) team.emplace_back([&all_started] { all_started.arrive_and_wait(); });
  for (auto& thread : team) thread.join();
}

/// Runs the task where OpenMP's threads can be started. libgomp keeps a team for each thread that has had one. If the firmware's has, this
/// one's memory says so, too, and it would wait for ever for threads that a fork does not copy. A new thread has no team yet.
[[noreturn]] void run_task(SharedMemory& memory, std::uint32_t threads, ChildTask task) {
  const auto run = [&] {
    task(memory, threads);
    ::_exit(0);
  };
  if (threads > 1) {
    std::thread(run).join();
  } else {
    run();
  }
  ::_exit(0);
}

[[noreturn]] void run_child(std::span<const int> files, pid_t parent, SharedMemory& memory, std::uint32_t threads,
                            ChildTask task) {
  end_with(parent);
  ::prctl(PR_SET_NAME, "plumbline-scan", 0, 0, 0);
  ::close(kKeptDescriptor);
  if (files.empty()) ::_exit(1);
  for (std::size_t i = 0; i < files.size(); ++i) {
    if (files[i] != static_cast<int>(i)) ::_exit(1);  // the lowest free numbers
  }
  static_cast<void>(lock_memory(Untouched::kLeave));  // not inherited
  run_task(memory, threads, task);
}

class Template {
 public:
  Template(SharedMemory& memory, std::uint32_t threads, ChildTask task)
      : memory_(memory), threads_(threads), task_(task) {}

  /// Serves until the firmware's end of the socket closes.
  void serve() {
    for (;;) {
      // A negative descriptor is ignored.
      std::array<pollfd, 2> files = {{{kKeptDescriptor, POLLIN, 0}, {process_file_, POLLIN, 0}}};
      if (::poll(files.data(), files.size(), -1) < 0) continue;
      if (files[1].revents != 0) report_end();
      if (files[0].revents != 0 && !obey()) break;
    }
    if (child_ > 0) ::kill(child_, SIGKILL);
  }

 private:
  /// @returns false: the firmware is gone
  bool obey() {
    ChildMessage message;
    const auto received = receive_message(kKeptDescriptor, std::as_writable_bytes(std::span(&message, 1)));
    if (!received || received->bytes != sizeof message) return false;
    if (message.word == ChildWord::kStart) start(*received);
    if (message.word == ChildWord::kKill && child_ > 0) ::kill(child_, SIGKILL);
    return true;
  }

  void start(const ReceivedMessage& files) {
    const pid_t self = ::getpid();
    child_ = ::fork();
    if (child_ == 0) run_child(files.descriptors(), self, memory_, threads_, task_);
    files.close_descriptors();
    // By number: C libraries older than Debian 12's lack the function.
    if (child_ > 0) process_file_ = static_cast<int>(::syscall(SYS_pidfd_open, child_, 0));
    if (child_ < 0 || process_file_ < 0) report_end();
  }

  /// Waits for the child, all its threads included.
  void report_end() {
    ChildMessage message;
    message.word = ChildWord::kEnded;
    message.status = 1 << 8;  // exit status 1, if it could not be started
    if (child_ > 0) {
      if (process_file_ < 0) ::kill(child_, SIGKILL);
      ::waitpid(child_, &message.status, 0);
    }
    if (process_file_ >= 0) ::close(process_file_);
    process_file_ = -1;
    child_ = -1;
    static_cast<void>(send(message));  // if it fails, the firmware is gone, which obey() notices
  }

  SharedMemory& memory_;
  std::uint32_t threads_;
  ChildTask task_;
  pid_t child_ = -1;
  int process_file_ = -1;  ///< readable when the child has ended
};

}  // namespace

void run_child_template(int socket, SharedMemory& memory, std::uint32_t threads, ChildTask task, pid_t firmware) {
  // In a process group of its own: Ctrl-C in a terminal must reach only the firmware.
  ::setpgid(0, 0);
  ::prctl(PR_SET_NAME, "plumbline-scans", 0, 0, 0);
  reserve_heap();
  leave_stacks(threads);
  const auto landlock = give_up_rights(socket);
  end_with(firmware);
  ChildMessage message;
  message.word = landlock ? ChildWord::kReady : ChildWord::kNotReady;
  if (landlock) {
    message.landlock = *landlock ? 1 : 0;
  } else {
    std::string_view(landlock.error().message()).copy(message.reason, sizeof message.reason - 1);
  }
  if (send(message) && landlock) Template(memory, threads, task).serve();
  ::_exit(0);
}

}  // namespace plumbline::firmware
