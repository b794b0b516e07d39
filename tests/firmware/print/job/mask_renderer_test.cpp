#include "firmware/print/job/mask_renderer.hpp"

#include <gtest/gtest.h>

#include <array>
#include <random>
#include <vector>

namespace plumbline::firmware {
namespace {

/// An image that owns its words.
struct Image {
  Image(std::uint32_t columns, std::uint32_t rows)
      : words(BitImage::words_needed(columns, rows)), image(words, columns, rows) {}
  std::vector<std::uint64_t> words;
  BitImage image;
};

/// What the docstring of erode() describes, pixel by pixel.
void erode_slowly(BitImage image, std::uint32_t steps) {
  for (std::uint32_t step = 0; step < steps; ++step) {
    Image before(image.columns(), image.rows());
    std::copy(image.words().begin(), image.words().end(), before.words.begin());
    const auto white = [&](std::int64_t x, std::int64_t y) {
      return x >= 0 && y >= 0 && x < image.columns() && y < image.rows() &&
             before.image.at(static_cast<std::uint32_t>(x), static_cast<std::uint32_t>(y));
    };
    image.clear();
    for (std::int64_t y = 0; y < image.rows(); ++y) {
      for (std::int64_t x = 0; x < image.columns(); ++x) {
        bool kept = white(x, y);
        for (int dy = -1; dy <= 1; ++dy) {
          for (int dx = -1; dx <= 1; ++dx) {
            if (step % 2 == 0 && dx != 0 && dy != 0) continue;
            kept = kept && white(x + dx, y + dy);
          }
        }
        if (kept) image.set(static_cast<std::uint32_t>(x), static_cast<std::uint32_t>(y));
      }
    }
  }
}

TEST(Erode, AgreesWithAPixelByPixelLoop) {
  std::mt19937 random(7);
  for (const std::uint32_t columns : {1U, 5U, 63U, 64U, 65U, 130U, 192U}) {
    for (const std::uint32_t steps : {0U, 1U, 2U, 3U, 5U}) {
      Image fast(columns, 40);
      for (int blob = 0; blob < 4; ++blob) {
        const auto x0 = random() % columns;
        const auto y0 = random() % 40;
        for (auto y = y0; y < std::min<std::size_t>(40, y0 + 20); ++y) {
          for (auto x = x0; x < std::min<std::size_t>(columns, x0 + 70); ++x) {
            if (random() % 50 != 0) fast.image.set(static_cast<std::uint32_t>(x), static_cast<std::uint32_t>(y));
          }
        }
      }
      Image slow(columns, 40);
      slow.words = fast.words;
      slow.image = BitImage(slow.words, columns, 40);
      std::vector<std::uint64_t> scratch(3 * fast.image.stride());
      erode(fast.image, steps, scratch);
      erode_slowly(slow.image, steps);
      EXPECT_EQ(fast.words, slow.words) << columns << " columns, " << steps << " steps";
    }
  }
}

}  // namespace
}  // namespace plumbline::firmware
