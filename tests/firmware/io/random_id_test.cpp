#include "firmware/io/random_id.hpp"

#include <gtest/gtest.h>

#include <set>
#include <string>

namespace plumbline::firmware {
namespace {

TEST(RandomIds, AreNeverTheSameAndNeverThoseOfAnotherStart) {
  std::set<std::uint64_t> seen;
  for (int starts = 0; starts < 100; ++starts) {
    RandomIds ids;
    for (int i = 0; i < 100; ++i) EXPECT_TRUE(seen.insert(ids.next()).second);
  }
  EXPECT_FALSE(seen.contains(0));
}

TEST(RandomIds, OfASeedAreAlwaysTheSame) {
  RandomIds one(7), other(7);
  EXPECT_EQ(one.next(), other.next());
  EXPECT_NE(RandomIds(7).next(), RandomIds(8).next());
  // The state before the one that mix64() makes 0 of.
  RandomIds zero(0U - 0x9E3779B97F4A7C15U);
  EXPECT_NE(zero.next(), 0U);
}

TEST(RandomIds, AreSixteenDigits) {
  for (const std::uint64_t id : {std::uint64_t{1}, std::uint64_t{0xfedcba9876543210}, UINT64_MAX}) {
    EXPECT_EQ(id_text(id).view().size(), 16U);
    EXPECT_EQ(id_of(id_text(id).view()), id);
  }
  for (const char* text :
       {"", "0000000000000000", "1", "000000000000001g", "+000000000000001", "00000000000000001", "FEDCBA9876543210"}) {
    EXPECT_FALSE(id_of(text)) << text;
  }
}

}  // namespace
}  // namespace plumbline::firmware
