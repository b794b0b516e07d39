#pragma once

#include <gtest/gtest.h>
#include <lodepng.h>

#include <array>
#include <cstdint>
#include <cstdlib>
#include <random>
#include <vector>

namespace plumbline::testing {

/// A PNG of noise, and its pixels as 8-bit RGBA as lodepng has them.
struct NoisePng {
  std::vector<unsigned char> file, rgba;

  NoisePng(LodePNGColorType colour, unsigned depth, std::uint32_t columns, std::uint32_t rows,
           bool interlaced = false) {
    LodePNGState state;
    lodepng_state_init(&state);
    state.info_raw.colortype = state.info_png.color.colortype = colour;
    state.info_raw.bitdepth = state.info_png.color.bitdepth = depth;
    state.info_png.interlace_method = interlaced ? 1 : 0;
    state.encoder.auto_convert = 0;
    std::mt19937 random(depth + colour);
    if (colour == LCT_PALETTE) {
      for (unsigned i = 0; i < 1U << depth; ++i) {
        std::array<unsigned char, 4> entry{};
        for (auto& channel : entry) channel = static_cast<unsigned char>(random());
        lodepng_palette_add(&state.info_png.color, entry[0], entry[1], entry[2], entry[3]);
        lodepng_palette_add(&state.info_raw, entry[0], entry[1], entry[2], entry[3]);
      }
    }
    std::vector<unsigned char> raw(lodepng_get_raw_size(columns, rows, &state.info_raw));
    for (auto& byte : raw) byte = static_cast<unsigned char>(random());
    unsigned char* png = nullptr;
    std::size_t size = 0;
    EXPECT_EQ(lodepng_encode(&png, &size, raw.data(), columns, rows, &state), 0U);
    lodepng_state_cleanup(&state);
    file.assign(png, png + size);
    std::free(png);
    unsigned width = 0, height = 0;
    EXPECT_EQ(lodepng::decode(rgba, width, height, file, LCT_RGBA, 8), 0U);
  }
};

}  // namespace plumbline::testing
