/// What a browser reaches the printer by, from lists of network interfaces.

#include "firmware/io/own_address.hpp"

#include <arpa/inet.h>
#include <gtest/gtest.h>
#include <ifaddrs.h>
#include <net/if.h>
#include <netinet/in.h>

#include <string>
#include <vector>

namespace plumbline::firmware {
namespace {

constexpr unsigned kUp = IFF_UP | IFF_RUNNING | IFF_BROADCAST;

struct Interface {
  unsigned flags;
  const char* address;  ///< IPv4; "": an IPv6 one; nullptr: none at all
};

std::string host_of(const std::vector<Interface>& interfaces, const char* name = "printer") {
  std::vector<ifaddrs> list(interfaces.size());
  std::vector<sockaddr_in> four(interfaces.size());
  std::vector<sockaddr_in6> six(interfaces.size());
  for (std::size_t i = 0; i < list.size(); ++i) {
    list[i].ifa_next = i + 1 < list.size() ? &list[i + 1] : nullptr;
    list[i].ifa_flags = interfaces[i].flags;
    if (interfaces[i].address == nullptr) continue;
    four[i].sin_family = AF_INET;
    six[i].sin6_family = AF_INET6;
    const bool is_four = ::inet_pton(AF_INET, interfaces[i].address, &four[i].sin_addr) == 1;
    list[i].ifa_addr = is_four ? reinterpret_cast<sockaddr*>(&four[i]) : reinterpret_cast<sockaddr*>(&six[i]);
  }
  return std::string(reachable_host(list.empty() ? nullptr : list.data(), name).view());
}

TEST(OwnAddress, IsTheFirstOneThatOthersReach) {
  EXPECT_EQ(host_of({{kUp | IFF_LOOPBACK, "127.0.0.1"},
                     {IFF_UP, "10.0.0.1"},  // without a cable
                     {kUp | IFF_POINTOPOINT, "10.8.0.2"},
                     {kUp, nullptr},
                     {kUp, ""},
                     {kUp, "169.254.7.8"},
                     {kUp, "192.168.178.105"},
                     {kUp, "192.168.2.2"}}),
            "192.168.178.105");
}

TEST(OwnAddress, IsTheNameWhereThereIsNoSuchAddress) {
  EXPECT_EQ(host_of({{kUp, ""}}), "printer.local");
  EXPECT_EQ(host_of({{kUp, "169.254.7.8"}}, "printer.workshop.example"), "printer.local");
  EXPECT_EQ(host_of({{kUp, ""}}, ""), "");
  const std::string longest(64, 'n');
  EXPECT_EQ(host_of({{kUp, ""}}, longest.c_str()), longest + ".local");
}

TEST(OwnAddress, IsNoneWithoutANetwork) {
  EXPECT_EQ(host_of({}), "");
  EXPECT_EQ(host_of({{kUp | IFF_LOOPBACK, "127.0.0.1"}, {IFF_BROADCAST, "192.168.1.2"}}), "");
}

}  // namespace
}  // namespace plumbline::firmware
