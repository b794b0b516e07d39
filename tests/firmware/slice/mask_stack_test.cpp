#include "firmware/slice/mask_stack.hpp"

#include <gmock/gmock.h>
#include <gtest/gtest.h>
#include <lodepng.h>

#include <filesystem>

#include "firmware/pictures/mask_decoder.hpp"
#include "firmware/pictures/png.hpp"
#include "tests/firmware/support/job_fixture.hpp"
#include "tests/slicer/support/pixels.hpp"
#include "tests/slicer/support/surfaces.hpp"

namespace plumbline::firmware {
namespace {

using ::testing::HasSubstr;
using testing::OwnedImage;
using testing::Pixels;
using testing::Random;

constexpr unsigned kColumns = 131;
constexpr unsigned kRows = 37;

/// Grey levels at random, written by lodepng in one of its formats.
std::vector<unsigned char> write_grey(const std::string& path, Random& random, unsigned bits,
                                      unsigned columns = kColumns) {
  std::vector<unsigned char> grey(std::size_t{columns} * kRows);
  for (auto& level : grey) level = static_cast<unsigned char>(bits == 1 ? 255 * random.below(2) : random.below(256));
  lodepng::State state;
  state.info_raw.colortype = LCT_GREY;
  state.info_raw.bitdepth = 8;
  state.info_png.color.colortype = LCT_GREY;
  state.info_png.color.bitdepth = bits;
  state.encoder.auto_convert = 0;
  std::vector<unsigned char> file;
  EXPECT_EQ(lodepng::encode(file, grey, columns, kRows, state), 0U);
  EXPECT_EQ(lodepng::save_file(file, path), 0U);
  return grey;
}

TEST(MaskStack, ReadsPngFilesOfOneAndEightBitsInTheOrderOfTheirNumbers) {
  const TemporaryFolder folder;
  Random random(3);
  // 2 comes before 10 although its name comes after it, and pictures without a number are no layers.
  const auto second = write_grey(folder / "part2_layer10.png", random, 1);
  const auto first = write_grey(folder / "part2_layer2.PNG", random, 8);
  write_grey(folder / "preview.png", random, 8, 50);
  write_text(folder / "readme.txt", "no layer");
  auto stack = MaskStack::open(folder / "");
  ASSERT_TRUE(stack) << stack.error().message();
  ASSERT_EQ(stack->layers(), 2U);
  EXPECT_EQ(stack->columns(), kColumns);
  EXPECT_EQ(stack->rows(), kRows);
  EXPECT_FALSE(stack->scale());
  OwnedImage mask(kColumns, kRows);
  for (std::uint32_t k = 0; k < 2; ++k) {
    ASSERT_TRUE(stack->read(k, mask.view()));
    EXPECT_TRUE(mask.clear_past_the_last_column());
    const auto& grey = k == 0 ? first : second;
    for (unsigned r = 0; r < kRows; ++r) {
      for (unsigned c = 0; c < kColumns; ++c) ASSERT_EQ(mask.view().at(c, r), grey[r * kColumns + c] > 127);
    }
  }
}

TEST(MaskStack, ReadsWhatThePngEncoderWrites) {
  const TemporaryFolder folder;
  Random random(4);
  Pixels pixels(kColumns, kRows);
  for (unsigned r = 0; r < kRows; ++r) {
    for (unsigned c = 0; c < kColumns; ++c) pixels.set(c, r, random.below(3) == 0);
  }
  auto encoder = PngEncoder::for_masks(kColumns, kRows);
  ASSERT_TRUE(encoder);
  const OwnedImage image = pixels.image();
  OwnedImage read(kColumns, kRows);
  ASSERT_TRUE(decode_mask(encoder->encode(image.view()), read.view()));
  EXPECT_EQ(Pixels(read.view()), pixels);
}

TEST(MaskStack, SaysWhatIsWrongWithAFile) {
  const TemporaryFolder folder;
  Random random(5);
  EXPECT_THAT(MaskStack::open(folder / "").error().message(), HasSubstr("0 PNG files with a number"));
  EXPECT_EQ(MaskStack::open(folder / "missing").error().code(), ErrorCode::kCannotOpen);
  write_grey(folder / "1.png", random, 8);
  write_grey(folder / "2.png", random, 8, 50);
  write_text(folder / "3.png", "no picture");
  OwnedImage mask(kColumns, kRows);
  {
    auto stack = MaskStack::open(folder / "");
    ASSERT_TRUE(stack) << stack.error().message();
    EXPECT_TRUE(stack->read(0, mask.view()));
    EXPECT_THAT(stack->read(1, mask.view()).error().message(),
                HasSubstr("2.png: has 50 x 37 pixels, the first layer 131 x 37"));
    EXPECT_THAT(stack->read(2, mask.view()).error().message(), HasSubstr("3.png: cannot be read as PNG"));
  }
  std::filesystem::copy(folder / "1.png", folder / "a1.png");
  EXPECT_THAT(MaskStack::open(folder / "").error().message(), HasSubstr("have the same number"));
}

TEST(MaskStack, RefusesAStackWithoutOneOfItsLayers) {
  const TemporaryFolder folder;
  Random random(6);
  for (const char* name : {"1.png", "2.png", "4.png", "preview3.png", "thumbnail400x400.png"}) {
    write_grey(folder / name, random, 8);
  }
  const auto missing = MaskStack::open(folder / "");
  ASSERT_FALSE(missing);
  EXPECT_EQ(missing.error().code(), ErrorCode::kMalformed);
  EXPECT_THAT(missing.error().message(), HasSubstr("layer 3 is missing between 2 and 4"));
  write_grey(folder / "3.png", random, 8);
  const auto whole = MaskStack::open(folder / "");
  ASSERT_TRUE(whole) << whole.error().message();
  EXPECT_EQ(whole->layers(), 4U);
}

TEST(MaskStack, TakesTheLumaOfColours) {
  const TemporaryFolder folder;
  const std::vector<unsigned char> pixels(std::size_t{3} * 4 * 4, 200);
  lodepng::State state;
  state.info_raw.colortype = LCT_RGB;
  state.info_png.color.colortype = LCT_RGB;
  state.encoder.auto_convert = 0;
  std::vector<unsigned char> file;
  ASSERT_EQ(lodepng::encode(file, pixels, 4, 4, state), 0U);
  ASSERT_EQ(lodepng::save_file(file, folder / "1.png"), 0U);
  auto stack = MaskStack::open(folder / "");
  ASSERT_TRUE(stack) << stack.error().message();
  OwnedImage mask(4, 4);
  ASSERT_TRUE(stack->read(0, mask.view()));
  EXPECT_EQ(mask.view().count(), 16U);
}

TEST(MaskStack, FindsPitchAndHeightInAManifest) {
  const auto ours = scale_in_manifest(
      "{ \"printer\": \"mono2k\", \"grid\": { \"pixel_pitch_mm\": [0.05, 0.0475],\n  \"layer_height_mm\": 0.1 } }");
  ASSERT_TRUE(ours);
  EXPECT_EQ(ours->pitch_x_mm, 0.05);
  EXPECT_EQ(ours->pitch_y_mm, 0.0475);
  EXPECT_EQ(ours->layer_height_mm, 0.1);
  EXPECT_TRUE(ours->has_panel);
  EXPECT_FALSE(
      scale_in_manifest("{\"printer\": null, \"pixel_pitch_mm\": [0.1, 0.1], \"layer_height_mm\": 0.1}")->has_panel);
  const auto single = scale_in_manifest("{\"pixel_pitch_mm\": 0.05, \"layer_height_mm\": 0.05}");
  ASSERT_TRUE(single);
  EXPECT_EQ(single->pitch_y_mm, 0.05);
  for (const char* const bad :
       {"", "{}", "{\"pixel_pitch_mm\": \"x\", \"layer_height_mm\": 1}", "{\"pixel_pitch_mm\": 0.05}",
        "{\"pixel_pitch_mm\": 50, \"layer_height_mm\": 0.05}", "\"pixel_pitch_mm\""}) {
    EXPECT_FALSE(scale_in_manifest(bad)) << bad;
  }
}

}  // namespace
}  // namespace plumbline::firmware
