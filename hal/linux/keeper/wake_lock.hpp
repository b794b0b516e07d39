#pragma once
/// Keeps a board awake that sleeps whenever nothing holds it.

namespace plumbline::inline hal::inline linux_board {

/// A wake-up event that is not handled while the lock is held (EPOLLWAKEUP): the same as a line in /sys/power/wake_lock, on kernels
/// with and without that file. It stops autosleep, and suspends that ask /sys/power/wakeup_count first. It needs CAP_BLOCK_SUSPEND
/// and does nothing without it. The kernel releases it with the process.
class WakeLock {
 public:
  WakeLock();
  WakeLock(const WakeLock&) = delete;
  WakeLock& operator=(const WakeLock&) = delete;
  ~WakeLock();

  void hold() noexcept;
  void release() noexcept;

 private:
  int event_ = -1;  ///< eventfd, readable while the lock is held
  int waits_ = -1;  ///< epoll
};

}  // namespace plumbline::inline hal::inline linux_board
