#pragma once
/// The firmware's watch over the keeper.

#include <atomic>
#include <chrono>
#include <condition_variable>
#include <memory>
#include <mutex>
#include <string>
#include <thread>

#include "hal/linux/keeper/lamp_line.hpp"
#include "hal/linux/keeper/process_handle.hpp"

namespace plumbline::inline hal::inline linux_board {

/// Pings the keeper from a thread of its own with real-time priority, so a busy main loop delays no ping. If the keeper does not
/// answer, it is killed. If it is gone, its line is taken, turned off and held, because a released line keeps its level.
class KeeperGuard {
 public:
  /// @param keeper  a child of this process, which nobody else waits for
  /// @param socket  connected to the keeper's watch socket; closed by the destructor
  /// @param line    of the lamp, for open_lamp_line()
  KeeperGuard(pid_t keeper, int socket, std::string line);
  KeeperGuard(const KeeperGuard&) = delete;
  KeeperGuard& operator=(const KeeperGuard&) = delete;
  /// Waits until the keeper has ended. Call expect_end() and tell the keeper to end before.
  ~KeeperGuard();

  /// Whether to watch at the pace of a lit lamp. Before a request for light.
  void watch_closely(bool closely);
  /// From now on the keeper may end: then its line is off, and is not taken.
  void expect_end() { expected_ = true; }
  /// Ends a keeper that answers pings and nothing else.
  void give_up();
  /// Waits until the keeper has ended and its line is off.
  /// @returns whether that is so
  bool await_dark(std::chrono::milliseconds time);
  /// Why the keeper is gone, for messages: "did not answer". Constant once await_dark() has returned.
  const char* reason() const { return reason_; }

 private:
  void run();
  void ping();
  void wake() const;
  /// Watches until the keeper has ended or been killed.
  void watch();
  /// Waits for the keeper's end, then takes its line.
  void take_line();

  pid_t keeper_;
  ProcessHandle process_;
  int socket_;
  int wake_;  ///< eventfd: one of the flags below has changed
  std::string line_;
  std::atomic<bool> closely_ = false;
  std::atomic<bool> expected_ = false;
  std::atomic<bool> given_up_ = false;
  std::atomic<bool> quit_ = false;
  std::atomic<const char*> reason_ = "has ended";
  std::uint64_t pings_ = 0;
  std::mutex mutex_;
  std::condition_variable changed_;
  bool dark_ = false;               ///< the keeper has ended and its line is off
  std::unique_ptr<LampLine> held_;  ///< once taken
  std::thread thread_;
};

}  // namespace plumbline::inline hal::inline linux_board
