#pragma once
/// How much each address may ask of the page. Paired browsers come first: what others ask is counted, and costs them alone.

#include <array>
#include <chrono>
#include <cstddef>
#include <cstdint>
#include <optional>

#include "firmware/io/token_bucket.hpp"
#include "firmware/page/clients/client_address.hpp"

namespace plumbline::firmware::inline page {

class ClientLimits {
 public:
  using HostClock = std::chrono::steady_clock;

  static constexpr std::size_t kMostAddresses = 64;
  /// An address counts as a paired browser's for so long after its last command, as its requests for pictures show no token.
  static constexpr std::chrono::hours kPairedTime{12};
  /// A page with all its pictures takes some 30 requests, moving a slider 10 a second.
  static constexpr TokenBucket::Size kRequests{100, 20};
  /// Of a paired browser's address, requests without its token.
  static constexpr TokenBucket::Size kPairedRequests{600, 150};
  /// Of all addresses that are not paired: whoever has many gets no more.
  static constexpr TokenBucket::Size kAllRequests{400, 200};
  /// Asking for a code, and trying one.
  static constexpr TokenBucket::Size kCodes{20, 0.5};

  /// A request with the token of a paired browser.
  /// @param browser  its number
  void showed_token(const ClientAddress& address, std::uint32_t browser, HostClock::time_point now);
  /// The browser is not paired any more, so neither is its address.
  void forget(std::uint32_t browser);

  bool is_paired(const ClientAddress& address, HostClock::time_point now) const;
  /// A request without a token. @returns whether it is served
  [[nodiscard]] bool takes_request(const ClientAddress& address, HostClock::time_point now);
  /// The same of one that asks for a code or tries one; it counts as a request, too.
  [[nodiscard]] bool takes_code(const ClientAddress& address, HostClock::time_point now);
  /// Whether an address asks so much in vain that its connections are refused at once.
  bool is_flooding(const ClientAddress& address, HostClock::time_point now) const;

 private:
  struct Client {
    ClientAddress address;
    bool is_taken = false;
    HostClock::time_point seen{};
    std::optional<HostClock::time_point> paired_at;  ///< when it last showed a token
    std::uint32_t browser = 0;
    TokenBucket requests{kRequests};
    TokenBucket paired_requests{kPairedRequests};
    TokenBucket codes{kCodes};
  };

  const Client* find(const ClientAddress& address) const;
  Client& client(const ClientAddress& address, HostClock::time_point now);
  static bool is_paired(const Client& client, HostClock::time_point now);

  std::array<Client, kMostAddresses> clients_;
  TokenBucket all_{kAllRequests};
};

}  // namespace plumbline::firmware::inline page
