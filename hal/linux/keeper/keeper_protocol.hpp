#pragma once
/// The messages between firmware and keeper, over a SOCK_SEQPACKET socket.
///
///   firmware -> keeper   request R: light for N ns     keeper arms its timer, turns the line on, replies "lit"
///   firmware -> keeper   request R: turn off           keeper turns the line off, replies "dark"
///   firmware -> keeper   request R: end                keeper turns the line off, stops the watchdog, exits
///   keeper -> firmware   R lit at T                    T: CLOCK_MONOTONIC, ns
///   keeper -> firmware   R dark at T                   also unrequested, when the time of R is over
///   keeper -> firmware   R failed                      nothing was lit
///   keeper -> firmware   R refused                     nothing was lit: above the board's limits of light
///   keeper -> firmware   cover opened at T             unrequested; the lamp is already off, and "dark" follows if it was lit
///   keeper -> firmware   cover closed at T             unrequested; the keeper also reports the cover's state when it starts
///
/// When the socket ends, the keeper turns the line off and exits.
///
/// A second socket carries the watch: the firmware sends pings, numbers of 8 bytes, and the keeper sends each back at once. The pace is
/// that of silence.hpp: quick while the lamp is lit, and from before the request for light.

#include <cstdint>
#include <type_traits>

namespace plumbline::inline hal::inline linux_board {

enum class KeeperWord : std::uint32_t {
  kLight = 1,
  kTurnOff = 2,
  kLit = 3,
  kDark = 4,
  kFailed = 5,
  kCoverOpened = 6,
  kCoverClosed = 7,
  kEnd = 8,
  kRefused = 9
};

struct KeeperMessage {
  static constexpr std::uint32_t kMagic = 0x504C4B31;  // "PLK1"
  std::uint32_t magic = kMagic;
  KeeperWord word = KeeperWord::kTurnOff;
  std::uint64_t request = 0;
  std::int64_t nanoseconds = 0;  ///< kLight: duration; otherwise CLOCK_MONOTONIC
};
static_assert(sizeof(KeeperMessage) == 24 && std::is_trivially_copyable_v<KeeperMessage>);

/// A ping. Its number only tells it from another.
using KeeperPing = std::uint64_t;

/// The keeper's descriptors.
inline constexpr int kKeeperSocket = 3;
inline constexpr int kKeeperWatchSocket = 4;

}  // namespace plumbline::inline hal::inline linux_board
