#include "firmware/page/clients/client_limits.hpp"

#include <arpa/inet.h>
#include <gtest/gtest.h>
#include <netinet/in.h>
#include <sys/socket.h>

#include <algorithm>
#include <string>
#include <utility>

#include "firmware/page/clients/connection_places.hpp"

namespace plumbline::firmware {
namespace {

using namespace std::chrono_literals;

ClientAddress host(unsigned number) {
  sockaddr_in four{};
  four.sin_family = AF_INET;
  four.sin_addr.s_addr = htonl(0xC0A80000U + number);
  return client_address(reinterpret_cast<const sockaddr*>(&four));
}
ClientAddress host6(const char* text) {
  sockaddr_in6 six{};
  six.sin6_family = AF_INET6;
  EXPECT_EQ(::inet_pton(AF_INET6, text, &six.sin6_addr), 1);
  return client_address(reinterpret_cast<const sockaddr*>(&six));
}

TEST(ClientAddress, IsThatOfAHostOrOfAnIpv6Network) {
  EXPECT_STREQ(text_of(host(7)).c_str(), "192.168.0.7");
  EXPECT_EQ(host(7), host6("::ffff:192.168.0.7")) << "a socket for both";
  EXPECT_NE(host(7), host(8));
  EXPECT_EQ(host6("2001:db8:1:2::1"), host6("2001:db8:1:2:ffff::2")) << "one machine may have all of them";
  EXPECT_NE(host6("2001:db8:1:2::1"), host6("2001:db8:1:3::1"));
  EXPECT_STREQ(text_of(host6("2001:db8:1:2::1")).c_str(), "2001:db8:1:2::/64");
  EXPECT_STREQ(text_of(host6("::1")).c_str(), "::1");
  EXPECT_EQ(client_address(nullptr), ClientAddress());
}

class ClientLimitsTest : public testing::Test {
 protected:
  /// @returns how many requests of an address are served, of so many a second for some time
  unsigned flood(const ClientAddress& address, unsigned a_second, unsigned seconds) {
    unsigned served = 0;
    for (unsigned i = 0; i < a_second * seconds; ++i) {
      now_ += std::chrono::nanoseconds(1'000'000'000 / a_second);
      served += limits_.takes_request(address, now_) ? 1 : 0;
    }
    return served;
  }

  ClientLimits limits_;
  ClientLimits::HostClock::time_point now_{5h};
};

TEST_F(ClientLimitsTest, LeaveAPersonAlone) {
  EXPECT_EQ(flood(host(1), 10, 60), 600U) << "moving a slider for a minute";
  now_ += 1min;
  EXPECT_EQ(flood(host(1), 1000, 1) >= 100, true) << "a page with all its pictures at once";
}

TEST_F(ClientLimitsTest, CostWhoeverFloodsAndNobodyElse) {
  limits_.showed_token(host(1), 1, now_);
  const unsigned served = flood(host(2), 1000, 10);
  EXPECT_LE(served, 100 + 10 * 20U);
  EXPECT_TRUE(limits_.is_flooding(host(2), now_));
  EXPECT_FALSE(limits_.is_flooding(host(3), now_));
  EXPECT_TRUE(limits_.takes_request(host(3), now_));
  EXPECT_TRUE(limits_.takes_request(host(1), now_));
  now_ += 10s;
  EXPECT_FALSE(limits_.is_flooding(host(2), now_));
  EXPECT_TRUE(limits_.takes_request(host(2), now_));
}

TEST_F(ClientLimitsTest, GiveManyAddressesTogetherNoMore) {
  limits_.showed_token(host(1), 1, now_);
  unsigned served = 0;
  for (unsigned i = 0; i < 100'000; ++i) {
    now_ += 100us;
    served += limits_.takes_request(host(2 + i % 5000), now_) ? 1 : 0;
  }
  EXPECT_LE(served, 400 + 10 * 200U);
  EXPECT_TRUE(limits_.is_paired(host(1), now_)) << "it keeps its place in the list";
  EXPECT_TRUE(limits_.takes_request(host(1), now_));
}

TEST_F(ClientLimitsTest, ForgetAPairedAddress) {
  limits_.showed_token(host(1), 1, now_);
  limits_.showed_token(host(2), 2, now_);
  EXPECT_EQ(flood(host(1), 100, 10), 1000U);
  EXPECT_TRUE(limits_.is_paired(host(1), now_));
  EXPECT_FALSE(limits_.is_paired(host(3), now_));
  limits_.forget(1);
  EXPECT_FALSE(limits_.is_paired(host(1), now_));
  EXPECT_TRUE(limits_.is_paired(host(2), now_));
  now_ += ClientLimits::kPairedTime;
  EXPECT_FALSE(limits_.is_paired(host(2), now_)) << "the address may be another's by now";
}

TEST_F(ClientLimitsTest, LetAnAddressAskForFewCodes) {
  unsigned taken = 0;
  for (int i = 0; i < 600; ++i, now_ += 100ms) taken += limits_.takes_code(host(1), now_) ? 1 : 0;
  EXPECT_LE(taken, 20 + 30U);
  EXPECT_TRUE(limits_.takes_code(host(2), now_));
}

class ConnectionPlaces : public testing::Test {
 protected:
  /// @returns whether it got in
  bool come(unsigned number, bool is_paired = false, bool may_end = true) {
    const auto choice = choose_place(held_, host(number), is_paired);
    if (choice.ends) held_[*choice.ends] = {};
    if (!choice.is_let_in) return false;
    auto* const place = std::ranges::find(held_, false, &HeldPlace::is_taken);
    if (place == held_.end()) return false;
    now_ += 1ms;
    *place = {host(number), true, is_paired, may_end, false, now_};
    return true;
  }
  std::size_t of(unsigned number) const {
    return static_cast<std::size_t>(std::ranges::count_if(
        held_, [&](const HeldPlace& one) { return one.is_taken && one.address == host(number); }));
  }

  std::array<HeldPlace, 32> held_;
  std::chrono::steady_clock::time_point now_{5h};
};

TEST_F(ConnectionPlaces, AreKeptForPairedBrowsers) {
  for (unsigned i = 0; i < 1000; ++i) come(2 + i % 50);
  for (unsigned i = 0; i < 12; ++i) EXPECT_TRUE(come(1, true)) << i;
  EXPECT_EQ(of(1), 12U);
  for (unsigned i = 0; i < 4; ++i) EXPECT_TRUE(come(1, true)) << "others make room";
  const auto oldest = std::ranges::min_element(
      held_, std::less<>(), [](const HeldPlace& one) { return std::pair(one.address != host(1), one.since); });
  const auto since = oldest->since;
  EXPECT_TRUE(come(1, true)) << "its own that waits longest makes room";
  EXPECT_EQ(of(1), 16U);
  EXPECT_FALSE(std::ranges::any_of(held_, [&](const HeldPlace& one) { return one.is_taken && one.since == since; }));
  for (unsigned i = 0; i < 1000; ++i) come(2 + i % 50);
  EXPECT_EQ(of(1), 16U);
}

TEST_F(ConnectionPlaces, AreNotAllTakenByFewAddresses) {
  for (unsigned i = 0; i < 32; ++i) come(2 + i % 2);
  EXPECT_EQ(of(2), 8U);
  EXPECT_EQ(of(3), 8U);
  for (unsigned i = 0; i < 8; ++i) come(4);
  EXPECT_EQ(of(4), 6U) << "then they share";
  EXPECT_EQ(of(2) + of(3), 14U);
  EXPECT_TRUE(come(5)) << "whoever has none gets one";
  EXPECT_TRUE(come(1, true));
}

TEST_F(ConnectionPlaces, AreNotTakenFromAStream) {
  for (unsigned i = 0; i < 20; ++i) EXPECT_TRUE(come(2 + i % 3, false, false));
  EXPECT_FALSE(come(6)) << "all are streams, or wait for the printer";
  EXPECT_TRUE(come(1, true));
}

}  // namespace
}  // namespace plumbline::firmware
