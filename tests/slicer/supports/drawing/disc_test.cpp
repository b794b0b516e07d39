#include "slicer/supports/drawing/disc.hpp"

#include <gtest/gtest.h>

#include <vector>

#include "slicer/core/bit_spans.hpp"
#include "slicer/supports/near.hpp"
#include "tests/slicer/support/arena_block.hpp"
#include "tests/slicer/support/pixels.hpp"
#include "tests/slicer/support/scan_cloud.hpp"
#include "tests/slicer/support/surfaces.hpp"

namespace plumbline {
namespace {

using namespace testing;

PixelPitch pitch_of(double x_mm, double y_mm) {
  PixelPitch pitch;
  pitch.x = nanometres(x_mm);
  pitch.y = nanometres(y_mm);
  return pitch;
}

/// Whether two pixels are at most `radius` apart: the definition of a disc.
bool within(std::int64_t dx, std::int64_t dy, const PixelPitch& pitch, Nanometres radius) {
  return dx * pitch.x * dx * pitch.x + dy * pitch.y * dy * pitch.y <= radius * radius;
}

TEST(Disc, HoldsThePixelsWithinItsRadius) {
  Random random(3);
  for (int i = 0; i < 200; ++i) {
    const std::uint32_t columns = 1 + random.below(150);
    const std::uint32_t rows = 1 + random.below(60);
    const std::uint32_t column = random.below(columns);
    const std::uint32_t row = random.below(rows);
    const PixelPitch pitch = pitch_of(random.uniform(0.015, 0.1), random.uniform(0.015, 0.1));
    const Nanometres radius = nanometres(random.uniform(0, 3));
    Pixels drawn(columns, rows);
    for_each_disc_span(pitch, column, row, radius, columns, rows,
                       [&](std::uint32_t r, std::uint32_t begin, std::uint32_t end) {
                         ASSERT_LT(begin, end);
                         ASSERT_LE(end, columns);
                         for (std::uint32_t c = begin; c < end; ++c) {
                           EXPECT_FALSE(drawn.at(c, r)) << "twice";
                           drawn.set(c, r, true);
                         }
                       });
    for (std::uint32_t r = 0; r < rows; ++r) {
      for (std::uint32_t c = 0; c < columns; ++c) {
        ASSERT_EQ(drawn.at(c, r), within(std::int64_t{c} - column, std::int64_t{r} - row, pitch, radius));
      }
    }
  }
}

/// A random image with a few white pixels, and a random radius.
struct NearCase {
  NearCase(Random& random, double widest_mm)
      : columns(1 + random.below(300)),
        rows(1 + random.below(40)),
        pitch(pitch_of(random.uniform(0.02, 0.1), random.uniform(0.02, 0.1))),
        radius(nanometres(random.uniform(0, widest_mm))),
        image(columns, rows) {
    for (std::uint32_t n = random.below(12); n > 0; --n) image.set(random.below(columns), random.below(rows), true);
  }

  std::uint32_t columns, rows;
  PixelPitch pitch;
  Nanometres radius;
  Pixels image;
};
double widest_mm(int i) { return i % 3 == 0 ? 6 : 1; }

TEST(Disc, FindsThePixelsNearAWhiteOne) {
  Random random(4);
  for (int i = 0; i < 60; ++i) {
    const NearCase made(random, widest_mm(i));
    const auto [columns, rows] = std::pair(made.columns, made.rows);
    const OwnedImage words = made.image.image();
    ArenaBlock arena(kMiB);
    const Disc disc = value_of(Disc::create(made.pitch, made.radius, *arena));
    EXPECT_EQ(arena->top_used(), Disc::bytes_needed(made.pitch, made.radius));
    for (std::uint32_t r = 0; r < rows; ++r) {
      for (std::uint32_t w = 0; w < words.view().stride(); ++w) {
        const std::uint64_t wanted = random.bits() | std::uint64_t{random.bits()} << 32;
        const std::uint64_t found = disc.near(words.view(), r, w, wanted);
        for (std::uint32_t c = w * 64; c < std::min(columns, w * 64 + 64); ++c) {
          bool near = false;
          for (std::uint32_t y = 0; y < rows && !near; ++y) {
            for (std::uint32_t x = 0; x < columns && !near; ++x) {
              near = made.image.at(x, y) && within(std::int64_t{x} - c, std::int64_t{y} - r, made.pitch, made.radius);
            }
          }
          ASSERT_EQ((found >> (c % 64) & 1U) != 0, near && (wanted >> (c % 64) & 1U) != 0) << c << ", " << r;
        }
      }
    }
  }
}

TEST(Disc, DrawsThePixelsNearAWhiteOneOnce) {
  Random random(5);
  for (int i = 0; i < 60; ++i) {
    const NearCase made(random, widest_mm(i));
    const auto [columns, rows] = std::pair(made.columns, made.rows);
    const OwnedImage words = made.image.image();
    ArenaBlock arena(kMiB);
    const Disc disc = value_of(Disc::create(made.pitch, made.radius, *arena));
    std::vector<std::uint64_t> drawn(BitImage::words_needed(columns, rows), 0);
    std::vector<std::uint64_t> visited = drawn;
    const BitImage near(drawn, columns, rows);
    const BitImage once(visited, columns, rows);
    for (std::uint32_t r = 0; r < rows; ++r) {
      disc.draw_near(words.view().row(r), r, near, [&](std::uint32_t row, std::uint32_t w, std::uint64_t bits) {
        EXPECT_EQ(once.row(row)[w] & bits, 0U) << "twice";
        once.row(row)[w] |= bits;
      });
    }
    EXPECT_EQ(drawn, visited);
    for (std::uint32_t r = 0; r < rows; ++r) {
      for (std::uint32_t w = 0; w < near.stride(); ++w) {
        const std::uint64_t inside = w + 1 == near.stride() ? near.last_word_mask() : ~std::uint64_t{0};
        ASSERT_EQ(near.row(r)[w], disc.near(words.view(), r, w, inside)) << w << ", " << r;
      }
    }
  }
}

TEST(Disc, CoversWholeWordsAndPartsOfThem) {
  for (std::uint32_t begin = 0; begin < 130; ++begin) {
    for (std::uint32_t end = begin + 1; end <= 130; ++end) {
      std::uint32_t next = begin;
      for_each_word(begin, end, [&](std::uint32_t w, std::uint64_t bits) {
        for (std::uint32_t b = 0; b < 64; ++b) {
          const bool in = w * 64 + b >= begin && w * 64 + b < end;
          ASSERT_EQ((bits >> b & 1U) != 0, in);
          next += in ? 1 : 0;
        }
      });
      ASSERT_EQ(next, end);
    }
  }
}

}  // namespace
}  // namespace plumbline
