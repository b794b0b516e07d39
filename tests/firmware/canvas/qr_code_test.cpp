/// The parts of a code that the standard fixes for any text (ISO/IEC 18004), and how it is drawn.

#include "firmware/canvas/qr_code.hpp"

#include <gtest/gtest.h>

#include <algorithm>
#include <string>
#include <vector>

namespace plumbline::firmware {
namespace {

constexpr std::string_view kAddress = "http://192.168.178.105:8080";

class QrCodes : public ::testing::Test {
 protected:
  void SetUp() override {
    if (!QrCode::is_built()) GTEST_SKIP() << "built without libqrencode";
  }
};

TEST_F(QrCodes, HaveAFinderInThreeCorners) {
  const QrCode code(kAddress);
  ASSERT_EQ(code.modules(), 25) << "version 2 takes 32 bytes";
  const int last = code.modules() - 1;
  // Rings around the middle of the finder: dark to distance 1, light at 2, dark at 3, light at 4.
  const auto ring_is_dark = [](int ring) { return ring <= 1 || ring == 3; };
  for (int y = 0; y <= 7; ++y) {
    for (int x = 0; x <= 7; ++x) {
      const bool dark = ring_is_dark(std::max(std::abs(x - 3), std::abs(y - 3)));
      EXPECT_EQ(code.is_dark(x, y), dark) << x << ", " << y;
      EXPECT_EQ(code.is_dark(last - x, y), dark) << x << ", " << y;
      EXPECT_EQ(code.is_dark(x, last - y), dark) << x << ", " << y;
    }
  }
}

TEST_F(QrCodes, DependOnTheText) {
  const QrCode code(kAddress), other("http://192.168.178.106:8080");
  int differ = 0;
  for (int y = 0; y < code.modules(); ++y) {
    for (int x = 0; x < code.modules(); ++x) differ += code.is_dark(x, y) != other.is_dark(x, y) ? 1 : 0;
  }
  EXPECT_GT(differ, 0);
}

TEST_F(QrCodes, GrowWithTheTextUpToTheirMost) {
  EXPECT_EQ(QrCode("").modules(), 0);
  EXPECT_EQ(QrCode(std::string(QrCode::kMostText, 'n')).modules(), QrCode::kMostModules);
  EXPECT_EQ(QrCode(std::string(QrCode::kMostText + 1, 'n')).modules(), 0);
}

TEST_F(QrCodes, AreDrawnWithTheirMargin) {
  const QrCode code(kAddress);
  EXPECT_EQ(code.side_in(112), 33 * 3);
  EXPECT_EQ(code.side_in(32), 0) << "too small for it";
  EXPECT_EQ(QrCode().side_in(112), 0);
  constexpr int kSide = 120, kAt = 10;
  std::vector<Colour> pixels(std::size_t{kSide} * kSide, colour(1, 2, 3));
  Canvas canvas(pixels, kSide, kSide);
  code.draw(canvas, kAt, kAt, 99);
  const auto is_dark = [&](int module_x, int module_y) {
    const int x = kAt + 3 * (module_x + 4) + 1, y = kAt + 3 * (module_y + 4) + 1;
    return pixels[static_cast<std::size_t>(y * kSide + x)] == colour(0, 0, 0);
  };
  for (int i = -4; i < 29; ++i) {
    EXPECT_FALSE(is_dark(i, -1)) << "the margin is light";
    EXPECT_FALSE(is_dark(-4, i));
  }
  for (int y = 0; y < 25; ++y) {
    for (int x = 0; x < 25; ++x) EXPECT_EQ(is_dark(x, y), code.is_dark(x, y));
  }
}

}  // namespace
}  // namespace plumbline::firmware
