#include <cstdio>

#include "tests/hil/lying_storage.hpp"

namespace plumbline::firmware {
namespace {

TEST(LyingStorage, After10000PowerCutsThePrintGoesOnAtTheRightLayerOrItsUserIsAsked) {
  const Tally tally = lose_and_resume(10'000, 2025);
  std::printf("resumed %d, confirmed by the user %d, given up %d, refused %d\n", tally.resumed, tally.confirmed,
              tally.given_up, tally.refused);
  EXPECT_GT(tally.resumed, 500);
  EXPECT_GT(tally.confirmed, 300);
  EXPECT_GT(tally.given_up, 2000);
  EXPECT_GT(tally.refused, 1000);
}

}  // namespace
}  // namespace plumbline::firmware
