#pragma once
/// Another process, by a descriptor that can't come to mean a third one when the number is used again.

#include <sys/types.h>

#include <chrono>

namespace plumbline::inline hal::inline linux_board {

class ProcessHandle {
 public:
  /// @param process  its ID; ok() says whether it exists
  explicit ProcessHandle(pid_t process);
  ProcessHandle(const ProcessHandle&) = delete;
  ProcessHandle& operator=(const ProcessHandle&) = delete;
  ~ProcessHandle();

  bool ok() const { return file_ >= 0; }
  /// For poll(): readable once it has ended. By then the kernel has released its lines.
  int descriptor() const { return file_; }
  /// SIGKILL, which also ends a stopped process.
  void kill() const;
  /// @returns whether it has ended
  bool await_end(std::chrono::milliseconds time) const;

 private:
  int file_ = -1;
};

}  // namespace plumbline::inline hal::inline linux_board
