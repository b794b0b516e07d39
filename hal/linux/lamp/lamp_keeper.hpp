#pragma once
/// The firmware's side of the keeper.

#include <sys/types.h>

#include <array>
#include <chrono>
#include <cstdint>
#include <memory>
#include <optional>
#include <string>

#include "hal/linux/keeper/light_budget.hpp"
#include "hal/linux/lamp/keeper_guard.hpp"
#include "slicer/core/error.hpp"

namespace plumbline::inline hal::inline linux_board {

struct KeeperMessage;

/// Starts the keeper and requests light from it. The lamp goes off when this object is destroyed or its process ends.
class LampKeeper {
 public:
  using Nanoseconds = std::chrono::nanoseconds;
  /// Longest wait for a reply. Longer tolerates a busier board, but a dead keeper then blocks the firmware for as long.
  static constexpr int kAnswerMs = 100;
  /// The same for the first reply, which includes starting the program on a slow board.
  static constexpr int kStartMs = 5000;

  /// What the keeper sends without a request.
  struct Notice {
    enum class Kind : std::uint8_t { kDark, kCoverOpened, kCoverClosed, kGone } kind = Kind::kDark;
    Nanoseconds at{};  ///< CLOCK_MONOTONIC
  };

  struct Settings {
    std::string program;                      ///< path of plumbline-keeper
    std::string line;                         ///< of the lamp, for open_lamp_line()
    std::string cover = {};                   ///< of its switch, for open_cover_line(); empty: the printer has none
    std::string watchdog = {};                ///< for Watchdog::open(); empty: the board has none
    std::chrono::seconds watchdog_timeout{};  ///< until the watchdog resets the board
    LightLimits limits = {std::chrono::seconds(300), LightBudget::kMinute};  ///< the widest that a board file allows
    Nanoseconds lit_before{};  ///< light that earlier keepers gave in the last minute
  };

  /// Call it from the thread that lives as long as the process: the kernel tells the keeper when that one ends.
  /// @retval ErrorCode::kLampFailed  it could not be started; it has written why to standard error
  [[nodiscard]] static Expected<LampKeeper> start(const Settings& settings);
  LampKeeper(LampKeeper&& other) noexcept;
  LampKeeper& operator=(LampKeeper&&) = delete;
  /// Tells the keeper to end, and waits until the lamp is off and it has ended.
  ~LampKeeper();

  /// Lights the lamp; off is armed before on.
  /// @returns when the line went on, CLOCK_MONOTONIC
  /// @retval ErrorCode::kExposureTooLong  not above 0, or above the limits; nothing was lit
  /// @retval ErrorCode::kLampFailed       no reply, and the keeper was ended; or it could not arm its timer or set the line
  [[nodiscard]] Expected<Nanoseconds> light(Nanoseconds cure);

  /// @returns when the line was off at the latest, CLOCK_MONOTONIC
  /// @retval ErrorCode::kLampFailed  no reply, and the keeper was ended
  [[nodiscard]] Expected<Nanoseconds> turn_off();

  /// When the lamp last went off; nothing while it is lit. Never waits.
  std::optional<Nanoseconds> went_dark();

  /// The oldest unread notice. Never waits. kGone comes once, when the keeper has ended.
  std::optional<Notice> next_notice();

  /// Once the keeper is gone: waits until its line is off and held by this process.
  /// @returns whether that is so
  bool await_dark(std::chrono::milliseconds time) { return guard_->await_dark(time); }
  /// Once the keeper is gone: why, for messages: "has ended", "did not answer".
  const char* reason() const { return guard_->reason(); }

  /// For poll(): readable when the keeper has sent something.
  int descriptor() const { return socket_; }
  pid_t process() const { return process_; }

 private:
  LampKeeper() = default;
  [[nodiscard]] Expected<Nanoseconds> await_answer(std::uint32_t word);
  /// Ends a keeper that does not answer, so that it can't light the lamp later. @returns the error
  tl::unexpected<Error> no_answer();
  void store(Notice::Kind kind, Nanoseconds at);
  void handle(const KeeperMessage& message);
  /// Handles all messages that have arrived.
  void receive();

  int socket_ = -1;
  pid_t process_ = -1;
  std::unique_ptr<KeeperGuard> guard_;  // null until the keeper has answered for the first time
  std::uint64_t request_ = 0;
  std::uint64_t lit_request_ = 0;  // the latest request for light
  std::optional<Nanoseconds> dark_at_;
  bool gone_ = false;
  std::array<Notice, 64> notices_{};
  std::size_t notice_count_ = 0;
};

}  // namespace plumbline::inline hal::inline linux_board
