#pragma once
/// What plumbline-page writes to its log. Nobody can fill it: a few lines a minute, then their number.

#include <chrono>

#include "firmware/io/token_bucket.hpp"
#include "firmware/page/clients/client_address.hpp"
#include "slicer/core/words/printable_text.hpp"

namespace plumbline::firmware::inline page {

class PageLog {
 public:
  using HostClock = std::chrono::steady_clock;

  static constexpr TokenBucket::Size kLines{10, 10.0 / 60};
  static constexpr std::chrono::minutes kBetweenCounts{1};

  void say(const PrintableText& text, HostClock::time_point now);
  /// Requests of an address were too many, and this one was refused.
  void refused(const ClientAddress& address) {
    ++refused_;
    last_ = address;
  }
  /// Connections got no place.
  void turned_away(unsigned count) { turned_away_ += count; }
  /// Writes how many that were, once a minute.
  void count(HostClock::time_point now);

 private:
  LogBound lines_{kLines};
  unsigned refused_ = 0, turned_away_ = 0;
  ClientAddress last_;
  HostClock::time_point counted_at_{};
};

}  // namespace plumbline::firmware::inline page
