#include "firmware/pictures/mask_window.hpp"

#include <gtest/gtest.h>

#include <memory>
#include <vector>

namespace plumbline::firmware {
namespace {

struct Image {
  Image(std::uint32_t columns, std::uint32_t rows)
      : words(BitImage::words_needed(columns, rows)), bits(words, columns, rows) {}
  std::vector<std::uint64_t> words;
  BitImage bits;
};

class MaskWindowTest : public ::testing::Test {
 protected:
  void draw(const MaskWindow& window, std::span<const GreyRun> greys = {}, ConstBitImage section = {}) {
    draw_mask_window(mask_.bits, greys, section, window, *picture_);
  }
  std::array<int, 3> at(std::uint32_t x, std::uint32_t y) const {
    const auto pixel = picture_->bytes().subspan(3 * (std::size_t{y} * picture_->columns + x), 3);
    return {pixel[0], pixel[1], pixel[2]};
  }
  Image mask_{1440, 2560};
  std::unique_ptr<MaskPicture> picture_ = std::make_unique<MaskPicture>();
};

TEST_F(MaskWindowTest, ShowsSinglePixels) {
  for (std::uint32_t i = 0; i < 500; ++i) mask_.bits.set(100 + i, 200 + i);
  draw({.column = 97, .row = 198, .step = 1});
  ASSERT_EQ(picture_->columns, 640U);
  ASSERT_EQ(picture_->rows, 640U);
  for (std::uint32_t y = 0; y < 640; ++y) {
    for (std::uint32_t x = 0; x < 640; ++x) {
      const int light = x + 97 >= 100 && x + 97 < 600 && x + 97 - 100 == y + 198 - 200 ? 255 : 0;
      ASSERT_EQ(at(x, y), (std::array{light, 0, 0})) << x << ", " << y;
    }
  }
}

TEST_F(MaskWindowTest, ShowsAllOfItOrWhatIsLeftOfIt) {
  mask_.bits.set(1439, 2559);
  draw({});
  EXPECT_EQ(picture_->columns, 360U);
  EXPECT_EQ(picture_->rows, 640U);
  EXPECT_EQ(at(359, 639)[0], 16) << "one of sixteen pixels";
  draw({.column = 1437, .row = 2558, .step = 2});
  EXPECT_EQ(picture_->columns, 2U);
  EXPECT_EQ(picture_->rows, 1U);
  EXPECT_EQ(at(1, 0)[0], 128) << "of a square that is cut, one of two";
  draw({.column = 1440, .row = 0, .step = 1});
  EXPECT_FALSE(picture_->there());
  draw({.column = 0, .row = 4000'000'000, .step = 4000'000'000});
  EXPECT_FALSE(picture_->there());
}

TEST_F(MaskWindowTest, TellsSupportsAndGrey) {
  Image section(1440, 2560);
  for (std::uint32_t x = 10; x < 20; ++x) mask_.bits.set(x, 5);
  for (std::uint32_t x = 10; x < 14; ++x) section.bits.set(x, 5);
  // A pixel whose bit is set, and a faint one whose bit is not; and one out of sight.
  const std::vector<GreyRun> greys = {{.pixel = 5, .count = 1, .level = 9},
                                      {.pixel = 5 * 1440 + 12, .count = 2, .level = 200},
                                      {.pixel = 5 * 1440 + 20, .count = 1, .level = 40}};
  draw({.column = 8, .row = 4, .step = 1}, greys, section.bits);
  EXPECT_EQ(at(2, 1), (std::array{255, 0, 0}));
  EXPECT_EQ(at(4, 1), (std::array{200, 0, 0}));
  EXPECT_EQ(at(5, 1), (std::array{200, 0, 0}));
  EXPECT_EQ(at(6, 1), (std::array{255, 255, 0})) << "only supports need it";
  EXPECT_EQ(at(12, 1), (std::array{40, 0, 0}));
  EXPECT_EQ(at(13, 1), (std::array{0, 0, 0}));
}

}  // namespace
}  // namespace plumbline::firmware
