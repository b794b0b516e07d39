#pragma once
/// What firmware and keeper say to each other, over a socket of whole messages (SOCK_SEQPACKET).
///
///   firmware -> keeper   light N ns, as request R      keeper arms its timer, turns the line on, answers "lit"
///   firmware -> keeper   darken, as request R          keeper turns the line off, answers "dark"
///   keeper -> firmware   lit R at T                    T: CLOCK_MONOTONIC, ns
///   keeper -> firmware   dark R at T                   also unasked, when the time of R is over
///   keeper -> firmware   failed R                      nothing was lit
///   keeper -> firmware   cover opened at T             unasked; what was lit is dark already, and "dark" follows
///   keeper -> firmware   cover closed at T             unasked; once when it starts, either this or the other
///
/// The end of the socket means dark: the keeper turns the line off and ends.

#include <cstdint>
#include <type_traits>

namespace plumbline {

enum class KeeperWord : std::uint32_t {
  kLight = 1,
  kDarken = 2,
  kLit = 3,
  kDark = 4,
  kFailed = 5,
  kCoverOpened = 6,
  kCoverClosed = 7
};

struct KeeperMessage {
  static constexpr std::uint32_t kMagic = 0x504C4B31;  // "PLK1"
  std::uint32_t magic = kMagic;
  KeeperWord word = KeeperWord::kDarken;
  std::uint64_t request = 0;
  std::int64_t nanoseconds = 0;  ///< kLight: how long; else: when
};
static_assert(sizeof(KeeperMessage) == 24 && std::is_trivially_copyable_v<KeeperMessage>);

/// Nothing is lit for longer, whatever is asked for.
inline constexpr std::int64_t kKeeperLongestNs = 300'000'000'000;

}  // namespace plumbline
