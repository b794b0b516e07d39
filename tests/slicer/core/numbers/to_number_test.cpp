#include "slicer/core/numbers/to_number.hpp"

#include <gtest/gtest.h>

#include <cstdint>

namespace plumbline {
namespace {

TEST(ToNumber, IsTheWholeTextOrNothing) {
  EXPECT_EQ(to_number<std::uint8_t>("255"), 255);
  EXPECT_EQ(to_number<std::int64_t>("-3"), -3);
  EXPECT_EQ(to_number<double>("12.5"), 12.5);
  for (const char* const text : {"", " 1", "1 ", "1s", "+1", "0x10", "256", "-1", "1.5"}) {
    EXPECT_EQ(to_number<std::uint8_t>(text), std::nullopt) << text;
  }
  EXPECT_EQ(to_number<double>("1,5"), std::nullopt);
  EXPECT_EQ(to_number<double>("1e999"), std::nullopt);
}

}  // namespace
}  // namespace plumbline
