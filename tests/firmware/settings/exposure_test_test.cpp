#include "firmware/settings/exposure_test.hpp"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

namespace plumbline::firmware {
namespace {

using ::testing::ElementsAre;
using ::testing::HasSubstr;

std::string said_of(std::string_view text) {
  const auto test = parse_exposure_test(text);
  return test ? "taken" : std::string(test.error().message());
}

TEST(ExposureTest, IsTwoToEightAscendingExposures) {
  const auto test = parse_exposure_test("1.6s,2s,2.4,2.8s");
  ASSERT_TRUE(test) << test.error().message();
  EXPECT_EQ(test->strips, 4U);
  EXPECT_THAT(std::vector(test->seconds.begin(), test->seconds.begin() + 4), ElementsAre(1.6, 2, 2.4, 2.8));
  EXPECT_EQ(test->longest(), 2.8);
  EXPECT_EQ(parse_exposure_test("1,2,3,4,5,6,7,8")->strips, 8U);
}

TEST(ExposureTest, SaysWhatItFoundAndWhatIsAllowed) {
  EXPECT_THAT(said_of(""), HasSubstr("found 1 exposure, allowed are 2 to 8"));
  EXPECT_THAT(said_of("2s"), HasSubstr("found 1 exposure, allowed are 2 to 8"));
  EXPECT_THAT(said_of("1,2,3,4,5,6,7,8,9"), HasSubstr("found 9 exposures, allowed are 2 to 8"));
  EXPECT_THAT(said_of("2s,1.6s"), HasSubstr("found 1.6 s after 2 s, allowed is a longer exposure"));
  EXPECT_THAT(said_of("2s,2s"), HasSubstr("found 2 s after 2 s"));
  EXPECT_THAT(said_of("2,,3"), HasSubstr("exposure 2 is empty"));
  EXPECT_THAT(said_of("2,"), HasSubstr("exposure 2 is empty"));
  EXPECT_THAT(said_of("s,2"), HasSubstr("exposure 1 is empty"));
  for (const char* const wrong : {"0.05s", "121s", "nan", "2ss", "two", "2 3"}) {
    EXPECT_THAT(said_of(std::string(wrong) + ",125"), HasSubstr("allowed is 0.1 to 120 s")) << wrong;
  }
}

}  // namespace
}  // namespace plumbline::firmware
