#include "firmware/pictures/job_pictures.hpp"

#include <gtest/gtest.h>
#include <lodepng.h>
#include <omp.h>

#include <algorithm>
#include <cmath>
#include <memory>
#include <numbers>
#include <random>
#include <vector>

#include "firmware/pictures/png.hpp"

namespace plumbline::firmware {
namespace {

struct Mask {
  Mask(std::uint32_t columns, std::uint32_t rows, unsigned seed)
      : words(BitImage::words_needed(columns, rows)), image(words, columns, rows) {
    std::mt19937 random(seed);
    for (std::uint32_t r = 0; r < rows; ++r) {
      for (std::uint32_t c = 0; c < columns; ++c) {
        if (random() % 1000 < c) image.set(c, r);
      }
    }
  }
  std::vector<std::uint64_t> words;
  BitImage image;
};

TEST(LayerPicture, HasTheMeanOfEachSquareOfTheMask) {
  struct Panel {
    std::uint32_t columns, rows;
  };
  for (const Panel panel :
       {Panel{1440, 2560}, Panel{3840, 2400}, Panel{640, 320}, Panel{321, 100}, Panel{7, 5}, Panel{16384, 70}}) {
    const Mask mask(panel.columns, panel.rows, 7);
    const auto picture = std::make_unique<LayerPicture>();
    draw_layer_picture(mask.image, {}, *picture);
    const std::uint32_t side = (std::max(panel.columns, panel.rows) + 319) / 320;
    ASSERT_EQ(picture->columns, (panel.columns + side - 1) / side);
    ASSERT_EQ(picture->rows, (panel.rows + side - 1) / side);
    for (std::uint32_t y = 0; y < picture->rows; ++y) {
      for (std::uint32_t x = 0; x < picture->columns; ++x) {
        std::uint32_t set = 0, all = 0;
        for (std::uint32_t r = y * side; r < std::min(panel.rows, (y + 1) * side); ++r) {
          for (std::uint32_t c = x * side; c < std::min(panel.columns, (x + 1) * side); ++c) {
            set += mask.image.at(c, r) ? 1 : 0;
            ++all;
          }
        }
        ASSERT_NEAR(picture->bytes()[y * picture->columns + x], 255.0 * set / all, 0.5001) << x << ", " << y;
      }
    }
  }
}

/// The R-Rep of a box in pixels and layers.
struct BoxRRep {
  explicit BoxRRep(const PrintGrid& grid) {
    const CrossingPacking packing(grid);
    for (std::uint32_t k = 0; k < grid.layers; ++k) {
      first.push_back(static_cast<std::uint32_t>(packed.size()));
      if (k > 0) continue;
      for (std::uint32_t r = 40; r < 60; ++r) {
        for (std::uint32_t c = 20; c < 80; ++c) packed.push_back(packing.packed(r * grid.columns + c));
      }
    }
    first.push_back(static_cast<std::uint32_t>(packed.size()));
    rrep = {grid, first, packed};
  }
  std::vector<std::uint32_t> first, packed;
  RRep rrep;
};

TEST(LayerPicture, ShowsWhatThePrintTakes) {
  std::vector<std::uint64_t> words(BitImage::words_needed(1440, 2560));
  const BitImage mask(words, 1440, 2560);
  for (std::uint32_t x = 700; x < 820; ++x) mask.set(x, 1300);
  const auto picture = std::make_unique<LayerPicture>();
  draw_layer_picture(mask, {.column = 700, .row = 1240, .columns = 120, .rows = 120}, *picture);
  EXPECT_EQ(picture->columns, 140U);
  EXPECT_EQ(picture->rows, 140U);
  EXPECT_EQ(picture->bytes()[70 * 140 + 9], 0);
  EXPECT_EQ(picture->bytes()[70 * 140 + 10], 255);
  EXPECT_EQ(picture->bytes()[70 * 140 + 129], 255);
  // At the panel's corner, and from a child that says anything.
  draw_layer_picture(mask, {.column = 1430, .row = 2555, .columns = 4000'000'000, .rows = 7}, *picture);
  EXPECT_TRUE(picture->there());
  draw_layer_picture(mask, {.column = 4000'000'000, .row = 0, .columns = 1, .rows = 1}, *picture);
  EXPECT_EQ(picture->columns, 180U) << "all of it";
}

TEST(PreviewPicture, ShowsTheThreeSidesOfABoxAtOneScale) {
  PrintGrid grid;
  grid.columns = grid.rows = 100;
  grid.layers = 30;
  grid.pitch_x_mm = grid.pitch_y_mm = grid.layer_height_mm = 0.1F;
  const BoxRRep box(grid);
  std::vector<std::byte> memory(preview_picture_bytes(grid) + Arena::kAlignment);
  Arena arena(memory);
  const auto picture = std::make_unique<PreviewPicture>();
  ASSERT_TRUE(draw_preview_picture(box.rrep, {}, arena, *picture));
  EXPECT_EQ(arena.used(), 0U);
  ASSERT_TRUE(picture->there());
  EXPECT_EQ(picture->columns, PreviewPicture::kMostColumns);
  // Along a row through all three: bright where there is a view, dark between them.
  const auto is_bright = [&](std::uint32_t x, std::uint32_t y) {
    const auto bytes = picture->bytes().subspan(3 * (std::size_t{y} * picture->columns + x), 3);
    return bytes[0] + bytes[1] + bytes[2] > 3 * 110;
  };
  std::vector<std::uint32_t> widths;
  bool inside = false;
  for (std::uint32_t x = 0; x < picture->columns; ++x) {
    const bool bright = is_bright(x, picture->rows / 2);
    if (bright && !inside) widths.push_back(0);
    if (bright) ++widths.back();
    inside = bright;
  }
  ASSERT_EQ(widths.size(), 3U) << "front, side and top";
  EXPECT_NEAR(static_cast<double>(widths[1]) / widths[0], 2.0 / 6, 0.03) << "2 mm deep, 6 mm wide";
  EXPECT_NEAR(static_cast<double>(widths[2]) / widths[0], 1, 0.03);

  std::vector<std::byte> little(100'000);
  Arena small(little);
  EXPECT_FALSE(draw_preview_picture(box.rrep, {}, small, *picture));
  EXPECT_FALSE(picture->there());
}

// What they are drawn in follows from what is drawn: a page of 1600 x 900 pixels would take 14 MB more, and ten times as long.
TEST(SmallPictures, AreDrawnAtTheirOwnSize) {
  PrintGrid grid;
  grid.columns = 1440;
  grid.rows = 2560;
  grid.layers = 3000;
  EXPECT_LT(preview_picture_bytes(grid), std::size_t{13} << 20U);
  // Two sections of 4 MiB. The second one is given back before the heights of the view from above are taken.
  grid.columns = 7680;
  grid.rows = 4320;
  EXPECT_LT(preview_picture_bytes(grid), std::size_t{12} << 20U);
  grid.columns = grid.rows = 100;
  EXPECT_LT(preview_picture_bytes(grid), std::size_t{3} << 20U);
}

TEST(SmallPng, IsReadBackByAnotherProgramAsItWas) {
  auto encoder = PictureEncoder::create(picture_bytes(320, 180)).value();
  std::mt19937 random(5);
  for (const std::uint32_t channels : {1U, 3U}) {
    for (const std::uint32_t columns : {1U, 7U, 320U}) {
      const std::uint32_t rows = 180 / channels;
      std::vector<std::uint8_t> pixels(std::size_t{channels} * columns * rows);
      for (auto& pixel : pixels) pixel = static_cast<std::uint8_t>(random());
      const auto file = encoder.encode(pixels, columns, rows, channels);
      const std::vector<unsigned char> bytes(reinterpret_cast<const unsigned char*>(file.data()),
                                             reinterpret_cast<const unsigned char*>(file.data()) + file.size());
      std::vector<unsigned char> read;
      unsigned width = 0, height = 0;
      ASSERT_EQ(lodepng::decode(read, width, height, bytes, channels == 3 ? LCT_RGB : LCT_GREY, 8), 0U);
      EXPECT_EQ(width, columns);
      EXPECT_EQ(height, rows);
      EXPECT_TRUE(read == pixels);
    }
  }
}

}  // namespace
}  // namespace plumbline::firmware
