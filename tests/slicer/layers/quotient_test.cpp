#include "slicer/layers/quotient.hpp"

#include <gtest/gtest.h>

#include <cstdint>

namespace plumbline {
namespace {

constexpr std::uint32_t kMost = ~std::uint32_t{0};

TEST(Quotient, IsThatOfADivisionNextToEveryMultiple) {
  for (const std::uint32_t divisor :
       {1U, 2U, 3U, 5U, 64U, 641U, 1440U, 3840U, 7680U, 65535U, 65536U, 1U << 31, kMost}) {
    const Quotient quotient(divisor);
    const std::uint32_t step = divisor > 100000 ? 1 : 100000 / divisor;  // multiples
    for (std::uint64_t multiple = 0; multiple <= kMost; multiple += std::uint64_t{divisor} * step) {
      for (const std::uint64_t near : {multiple - 1, multiple, multiple + 1}) {
        const auto number = static_cast<std::uint32_t>(near);
        ASSERT_EQ(quotient(number), number / divisor) << number << " / " << divisor;
      }
    }
    EXPECT_EQ(quotient(kMost), kMost / divisor) << divisor;
  }
}

}  // namespace
}  // namespace plumbline
