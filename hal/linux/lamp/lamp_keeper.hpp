#pragma once
/// The firmware's side of the keeper.

#include <sys/types.h>

#include <array>
#include <chrono>
#include <cstdint>
#include <optional>
#include <string>

#include "slicer/core/error.hpp"

namespace plumbline {

struct KeeperMessage;

/// Starts the keeper and requests light from it. The lamp goes off when this object is destroyed or its process ends.
class LampKeeper {
 public:
  using Nanoseconds = std::chrono::nanoseconds;
  /// Longest wait for a reply. Longer tolerates a busier board, but a dead keeper then blocks the firmware for as long.
  static constexpr int kAnswerMs = 100;

  /// What the keeper sends without a request.
  struct Notice {
    enum class Kind : std::uint8_t { kDark, kCoverOpened, kCoverClosed, kGone } kind = Kind::kDark;
    Nanoseconds at{};  ///< CLOCK_MONOTONIC
  };

  /// @param program  path of plumbline-keeper
  /// @param line     for its --line
  /// @param cover    for its --cover; empty: the printer has no cover switch
  /// @retval ErrorCode::kLampFailed  it could not be started
  [[nodiscard]] static Expected<LampKeeper> start(const std::string& program, const std::string& line,
                                                  const std::string& cover = "");
  LampKeeper(LampKeeper&& other) noexcept;
  LampKeeper& operator=(LampKeeper&&) = delete;
  /// Waits until the lamp is off and the keeper has ended.
  ~LampKeeper();

  /// Lights the lamp; off is armed before on.
  /// @param cure  above 0
  /// @returns when the line went on, CLOCK_MONOTONIC
  /// @retval ErrorCode::kLampFailed  no reply, or a refusal; turn_off() was tried
  [[nodiscard]] Expected<Nanoseconds> light(Nanoseconds cure);

  /// @returns when the line was off at the latest, CLOCK_MONOTONIC
  /// @retval ErrorCode::kLampFailed  no reply; the keeper's deadline still holds
  [[nodiscard]] Expected<Nanoseconds> turn_off();

  /// When the lamp last went off; nothing while it is lit. Never waits.
  std::optional<Nanoseconds> went_dark();

  /// The oldest unread notice. Never waits. kGone comes once, when the keeper has ended.
  std::optional<Notice> next_notice();

  /// For poll(): readable when the keeper has sent something.
  int descriptor() const { return socket_; }
  pid_t process() const { return process_; }

 private:
  LampKeeper() = default;
  [[nodiscard]] Expected<Nanoseconds> await_answer(std::uint32_t word);
  void store(Notice::Kind kind, Nanoseconds at);
  void handle(const KeeperMessage& message);
  /// Handles all messages that have arrived.
  void receive();

  int socket_ = -1;
  pid_t process_ = -1;
  std::uint64_t request_ = 0;
  std::uint64_t lit_request_ = 0;  // the latest request for light
  std::optional<Nanoseconds> dark_at_;
  bool gone_ = false;
  std::array<Notice, 64> notices_{};
  std::size_t notice_count_ = 0;
};

}  // namespace plumbline
