#pragma once
/// Codes by which browsers are paired: a person reads one on the printer's screen and types it into the browser that asked for it.
///
/// The screen shows one code at a time, and it is good for its browser alone. Others wait for their turn, in the order in which they asked.
/// Wrong codes cost whoever sent them, nobody else.

#include <array>
#include <chrono>
#include <cstdint>
#include <optional>
#include <string_view>

#include "firmware/io/text/fixed_text.hpp"
#include "firmware/page/clients/client_address.hpp"
#include "firmware/page/clients/client_limits.hpp"
#include "slicer/core/error.hpp"

namespace plumbline::firmware::inline page {

/// 6 decimal digits.
using PageCode = FixedText<8>;

/// A browser that wants to be paired.
struct Asker {
  std::string_view
      name;  ///< a secret that the browser has made for itself; empty: its address is all that is known of it
  ClientAddress address;
};

class PairingCodes {
 public:
  using HostClock = std::chrono::steady_clock;

  /// As long as the screen shows the code: StateRecorder::kCodeTime.
  static constexpr std::chrono::minutes kCodeTime{2};
  /// Wrong codes before a new one is needed.
  static constexpr unsigned kMostTries = 3;
  /// For a new code after three wrong ones; twice as long after each further three, up to kLongestWait.
  static constexpr std::chrono::minutes kFirstWait{1};
  static constexpr std::chrono::hours kLongestWait{1};
  /// Codes that were void after three wrong ones, of all addresses: five at once, then one a minute. At three wrong codes a minute, trying
  /// a million takes 230 days.
  static constexpr TokenBucket::Size kVoidCodes{5, 1.0 / 60};
  /// Whoever waits and has not asked again for this long is gone.
  static constexpr std::chrono::seconds kWaiterTime{10};
  static constexpr std::size_t kMostWaiters = 16;  ///< one of each address
  static constexpr std::size_t kLongestName = 64;

  /// A code for a browser. It is the one before as long as that is good for half a minute.
  /// @retval ErrorCode::kBusy  it has to wait: for another browser's code, or after wrong ones; told with the seconds
  [[nodiscard]] Expected<PageCode> ask(const Asker& asker, HostClock::time_point now);
  /// A person has typed a code. If it is right, it is used up.
  /// @retval ErrorCode::kBadSetting  it is wrong, or there is none for this browser any more
  /// @retval ErrorCode::kBusy        this browser has to wait
  [[nodiscard]] Status use(std::string_view code, const Asker& asker, HostClock::time_point now);
  /// A browser doesn't want its code any more.
  void give_up(const Asker& asker);

  /// What the screen shows; empty: nothing.
  std::string_view shown(HostClock::time_point now) const;
  /// Codes that were void after wrong ones, since the start: for the log.
  unsigned void_codes() const { return void_codes_; }

 private:
  using Name = FixedText<kLongestName + 1>;
  struct Who {
    Name name;
    ClientAddress address;
    bool is(const Asker& asker) const;
  };
  struct Waiter {
    Who who;
    HostClock::time_point since{}, seen{};
    bool is_there = false;
  };
  /// Whoever sent wrong codes.
  struct Offender {
    ClientAddress address;
    unsigned times = 0;
    HostClock::time_point until{};
  };

  static Who who(const Asker& asker);
  [[nodiscard]] Status check_offender(const Asker& asker, HostClock::time_point now) const;
  tl::unexpected<Error> wait(const Asker& asker, HostClock::time_point now);
  void void_code(const Asker& asker, HostClock::time_point now);

  PageCode code_;
  Who owner_;  ///< of code_
  HostClock::time_point valid_until_{};
  unsigned tries_ = 0;
  std::array<Waiter, kMostWaiters> waiters_;
  std::array<Offender, 32> offenders_;
  TokenBucket void_budget_{kVoidCodes};
  HostClock::time_point none_before_{};
  unsigned void_codes_ = 0;
};

}  // namespace plumbline::firmware::inline page
