#include "firmware/page/clients/access.hpp"

#include <gtest/gtest.h>

namespace plumbline::firmware {
namespace {

TEST(PageAccess, KnowsTheNamesOfThisMachine) {
  for (const char* const host :
       {"localhost", "localhost:8080", "LOCALHOST:1", "127.0.0.1", "127.0.0.1:8080", "[::1]:8080", "[::1]"}) {
    EXPECT_TRUE(is_known_host(host, PageChoice::kLocal, "")) << host;
    EXPECT_TRUE(is_known_host(host, PageChoice::kNetwork, "")) << host;
  }
  for (const char* const host :
       {"printer", "printer:8080", "printer.local", "Printer.LOCAL:8080", "192.168.1.5:8080", "[fe80::1]:8080"}) {
    EXPECT_FALSE(is_known_host(host, PageChoice::kLocal, "")) << host;
    EXPECT_TRUE(is_known_host(host, PageChoice::kNetwork, "")) << host;
  }
  for (const char* const host :
       {"", ":8080", "evil.example", "evil.example:8080", "127.0.0.1.evil.example", "localhost.evil.example", ".local",
        "[::1", "[evil.example]", "[]", "1.2.3.4.5", "evil.example#.local"}) {
    EXPECT_FALSE(is_known_host(host, PageChoice::kLocal, "")) << host;
  }
  EXPECT_FALSE(is_known_host("evil.example:8080", PageChoice::kNetwork, ""));
  EXPECT_FALSE(is_known_host("1.2.3.4.5", PageChoice::kNetwork, ""));
  EXPECT_FALSE(is_known_host("[evil.example]", PageChoice::kNetwork, ""));
  EXPECT_FALSE(is_known_host("evil.example", PageChoice::kNetwork, "printer.example"));
  EXPECT_TRUE(is_known_host("Printer.example:8443", PageChoice::kNetwork, "printer.example"));
  // Behind a proxy a local page would be everybody's, without a code.
  EXPECT_FALSE(is_known_host("printer.example", PageChoice::kLocal, "printer.example"));
}

TEST(PageAccess, TakesOnlyThePagesOwnOrigin) {
  EXPECT_TRUE(is_same_origin("printer:8080", "http://printer:8080"));
  EXPECT_TRUE(is_same_origin("printer.example", "https://Printer.example"));
  for (const char* const origin :
       {"", "null", "http://", "http://printer", "http://printer:80801", "http://evil.example", "ftp://printer:8080",
        "printer:8080", "http://printer:8080.evil.example", "http://printer:8080/"}) {
    EXPECT_FALSE(is_same_origin("printer:8080", origin)) << origin;
  }
  EXPECT_FALSE(is_same_origin("", "http://"));
}

}  // namespace
}  // namespace plumbline::firmware
