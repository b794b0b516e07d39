#include "firmware/settings/print_length.hpp"

#include <gtest/gtest.h>

namespace plumbline::firmware {
namespace {

TEST(PrintLength, IsANumberWithItsUnit) {
  EXPECT_EQ(parse_length("80mm"), 80);
  EXPECT_EQ(parse_length("80"), 80);
  EXPECT_EQ(parse_length("80.5 mm"), 80.5);
  EXPECT_EQ(parse_length("8cm"), 80);
  EXPECT_EQ(parse_length("2in"), 50.8);
  EXPECT_EQ(parse_length("1"), 1);
  EXPECT_EQ(parse_length("10000mm"), 10'000);
}

TEST(PrintLength, IsNothingElse) {
  for (const char* text : {"", "mm", "80m", "80 m", "80mmm", "80  mm", " 80", "-80mm", "0.9mm", "10001mm", "nan", "inf",
                           "8,5cm", "80mm "}) {
    EXPECT_FALSE(parse_length(text)) << text;
  }
}

}  // namespace
}  // namespace plumbline::firmware
