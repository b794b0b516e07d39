#include "slicer/core/numbers/mix64.hpp"

#include <gtest/gtest.h>

#include <bit>

namespace plumbline {
namespace {

// Steele, Lea, Flood 2014: the n-th output of SplitMix64 is the mix of seed + n steps. These are the first three of seed 0,
// as published with the generator.
TEST(Mix64, MakesTheOutputsOfSplitMix64) {
  EXPECT_EQ(mix64(1 * kGoldenStep64), 0xE220A8397B1DCDAFU);
  EXPECT_EQ(mix64(2 * kGoldenStep64), 0x6E789E6AA1B965F4U);
  EXPECT_EQ(mix64(3 * kGoldenStep64), 0x06C45D188009454FU);
}

TEST(Mix64, ChangesHalfOfTheBitsWhenOneChanges) {
  for (unsigned bit = 0; bit < 64; ++bit) {
    int changed = 0;
    for (std::uint64_t z = 1; z <= 256; ++z) {
      changed += std::popcount(mix64(z * kGoldenStep64) ^ mix64((z * kGoldenStep64) ^ (std::uint64_t{1} << bit)));
    }
    EXPECT_NEAR(changed / 256.0, 32, 2) << "bit " << bit;
  }
}

}  // namespace
}  // namespace plumbline
