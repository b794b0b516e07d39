#pragma once
/// Messages between processes that can carry file descriptors, over a socket of this machine: SOCK_SEQPACKET, or SOCK_STREAM for those that
/// are only sent.

#include <array>
#include <cstddef>
#include <optional>
#include <span>

namespace plumbline::inline hal {

inline constexpr std::size_t kMostPassed = 32;  ///< descriptors in a message

/// @param descriptors  the receiver gets a copy of each; kMostPassed at most
/// @returns false: errno has the reason
[[nodiscard]] bool send_message(int socket, std::span<const std::byte> bytes, std::span<const int> descriptors = {});

struct ReceivedMessage {
  std::size_t bytes = 0;                  ///< 0: the other end is closed
  std::array<int, kMostPassed> passed{};  ///< descriptors: close-on-exec, the caller's
  std::size_t passed_count = 0;

  std::span<const int> descriptors() const { return std::span(passed).first(passed_count); }
  void close_descriptors() const;
};

/// Waits for a message.
/// @param buffer  a longer message is cut
/// @returns nothing: errno has the reason
[[nodiscard]] std::optional<ReceivedMessage> receive_message(int socket, std::span<std::byte> buffer);

}  // namespace plumbline::inline hal
