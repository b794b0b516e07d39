#pragma once
/// The firmware's side of the keeper.

#include <sys/types.h>

#include <chrono>
#include <cstdint>
#include <optional>
#include <string>

#include "slicer/core/error.hpp"

namespace plumbline {

/// Starts the keeper and asks it for light. When this object ends, or the process that holds it, the lamp is dark.
class LampKeeper {
 public:
  using Nanoseconds = std::chrono::nanoseconds;
  /// Longest wait for an answer: the keeper does nothing else.
  static constexpr int kAnswerMs = 100;

  /// @param program  path of plumbline-keeper
  /// @param line     as its --line takes it
  /// @retval ErrorCode::kLampFailed  it could not be started
  [[nodiscard]] static Expected<LampKeeper> start(const std::string& program, const std::string& line);
  LampKeeper(LampKeeper&& other) noexcept;
  LampKeeper& operator=(LampKeeper&&) = delete;
  /// Dark, and the keeper has ended.
  ~LampKeeper();

  /// Off is armed before on.
  /// @param cure  above 0
  /// @returns when the line went on: CLOCK_MONOTONIC since its start
  /// @retval ErrorCode::kLampFailed  it does not answer, or refuses; darken() has been tried
  [[nodiscard]] Expected<Nanoseconds> light(Nanoseconds cure);

  /// @returns when the line went off, at the latest
  /// @retval ErrorCode::kLampFailed  no answer. The keeper's deadline still holds
  [[nodiscard]] Expected<Nanoseconds> darken();

  /// When the last light ended by itself; nothing while it is lit. Never waits.
  std::optional<Nanoseconds> went_dark();

  /// To wait for with poll(): readable when the keeper has something to say.
  int descriptor() const { return socket_; }
  pid_t process() const { return process_; }

 private:
  LampKeeper() = default;
  [[nodiscard]] Expected<Nanoseconds> await_answer(std::uint32_t word);

  int socket_ = -1;
  pid_t process_ = -1;
  std::uint64_t request_ = 0;
  std::optional<Nanoseconds> dark_at_;
};

}  // namespace plumbline
