#pragma once
/// Messages between processes that can carry a file descriptor, over a SOCK_SEQPACKET socket.

#include <cstddef>
#include <optional>
#include <span>

namespace plumbline {

/// @param descriptor  the receiver gets a copy of it; below 0: none
/// @returns false: errno has the reason
[[nodiscard]] bool send_message(int socket, std::span<const std::byte> bytes, int descriptor = -1);

struct ReceivedMessage {
  std::size_t bytes = 0;  ///< 0: the other end is closed
  int descriptor = -1;    ///< close-on-exec, the caller's; -1: none
};

/// Waits for a message.
/// @param buffer  a longer message is cut
/// @returns nothing: errno has the reason
[[nodiscard]] std::optional<ReceivedMessage> receive_message(int socket, std::span<std::byte> buffer);

}  // namespace plumbline
