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

/// Starts the keeper and asks it for light. When this object ends, or the process that holds it, the lamp is dark.
class LampKeeper {
 public:
  using Nanoseconds = std::chrono::nanoseconds;
  /// Longest wait for an answer: the keeper does nothing else.
  static constexpr int kAnswerMs = 100;

  /// What the keeper says unasked.
  struct News {
    enum class Kind : std::uint8_t { kDark, kCoverOpened, kCoverClosed, kGone } kind = Kind::kDark;
    Nanoseconds at{};  ///< CLOCK_MONOTONIC
  };

  /// @param program  path of plumbline-keeper
  /// @param line     as its --line takes it
  /// @param cover    as its --cover takes it; empty: the printer has no switch there
  /// @retval ErrorCode::kLampFailed  it could not be started
  [[nodiscard]] static Expected<LampKeeper> start(const std::string& program, const std::string& line,
                                                  const std::string& cover = "");
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

  /// The oldest of the keeper's news that was not asked for yet. Never waits. kGone comes once, when the keeper has ended.
  std::optional<News> next_news();

  /// To wait for with poll(): readable when the keeper has something to say.
  int descriptor() const { return socket_; }
  pid_t process() const { return process_; }

 private:
  LampKeeper() = default;
  [[nodiscard]] Expected<Nanoseconds> await_answer(std::uint32_t word);
  void keep(News::Kind kind, Nanoseconds at);
  void take(const KeeperMessage& message);
  /// Takes what has come from the socket.
  void listen();

  int socket_ = -1;
  pid_t process_ = -1;
  std::uint64_t request_ = 0;
  std::uint64_t lit_request_ = 0;  // the newest that asked for light
  std::optional<Nanoseconds> dark_at_;
  bool gone_ = false;
  std::array<News, 64> news_{};
  std::size_t news_count_ = 0;
};

}  // namespace plumbline
