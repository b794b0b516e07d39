#include "firmware/pictures/png.hpp"

#include <gtest/gtest.h>
#include <lodepng.h>

#include <optional>
#include <random>
#include <tuple>
#include <vector>

namespace plumbline::firmware {
namespace png_test {

struct Mask {
  Mask(std::uint32_t columns, std::uint32_t rows)
      : words(BitImage::words_needed(columns, rows), 0), image(words, columns, rows) {}
  std::vector<std::uint64_t> words;
  BitImage image;
};

/// A file decoded by lodepng: one byte for each pixel or channel.
struct Decoded {
  std::vector<unsigned char> bytes;
  unsigned columns = 0, rows = 0;
  LodePNGColorType type = LCT_PALETTE;
  unsigned depth = 0;
};
Decoded decode(std::span<const std::byte> png, LodePNGColorType type) {
  Decoded decoded;
  lodepng::State state;
  state.info_raw.colortype = type;
  state.info_raw.bitdepth = 8;
  const auto* bytes = reinterpret_cast<const unsigned char*>(png.data());
  EXPECT_EQ(lodepng::decode(decoded.bytes, decoded.columns, decoded.rows, state, bytes, png.size()), 0U);
  decoded.type = state.info_png.color.colortype;
  decoded.depth = state.info_png.color.bitdepth;
  return decoded;
}

void expect_round_trip(PngEncoder& encoder, const Mask& mask) {
  const Decoded decoded = decode(encoder.encode(mask.image), LCT_GREY);
  ASSERT_EQ(decoded.columns, mask.image.columns());
  ASSERT_EQ(decoded.rows, mask.image.rows());
  EXPECT_EQ(decoded.type, LCT_GREY);
  EXPECT_EQ(decoded.depth, 1U);
  for (std::uint32_t r = 0; r < decoded.rows; ++r) {
    for (std::uint32_t c = 0; c < decoded.columns; ++c) {
      ASSERT_EQ(decoded.bytes[std::size_t{r} * decoded.columns + c], mask.image.at(c, r) ? 255 : 0) << c << ' ' << r;
    }
  }
}

class PngOfAMask : public ::testing::TestWithParam<std::uint32_t> {};

TEST_P(PngOfAMask, DecodesToTheSamePixels) {
  std::mt19937_64 dice(GetParam());
  for (const std::uint32_t rows : {1U, 2U, 7U, 33U}) {
    auto encoder = PngEncoder::for_masks(GetParam(), rows);
    ASSERT_TRUE(encoder.has_value());
    Mask mask(GetParam(), rows);
    expect_round_trip(*encoder, mask);  // black
    for (std::uint32_t r = 0; r < rows; ++r) {
      for (std::uint32_t c = 0; c < GetParam(); ++c) {
        if (dice() % 3 == 0) mask.image.set(c, r);
      }
    }
    expect_round_trip(*encoder, mask);  // noise, which does not compress
    for (std::uint32_t r = 0; r < rows; ++r) {
      for (std::uint32_t c = 0; c < GetParam(); ++c) mask.image.set(c, r);
    }
    expect_round_trip(*encoder, mask);  // white
  }
}
INSTANTIATE_TEST_SUITE_P(OfAnyWidth, PngOfAMask,
                         ::testing::Values(1, 7, 8, 9, 63, 64, 65, 100, 127, 128, 129, 1440, 3841));

TEST(PngEncoder, EncodesSmallerMasksOneAfterAnother) {
  auto encoder = PngEncoder::for_masks(300, 200);
  ASSERT_TRUE(encoder.has_value());
  for (const std::uint32_t columns : {300U, 65U, 8U, 299U}) {
    Mask mask(columns, 17);
    for (std::uint32_t c = 0; c < columns; c += 3) mask.image.set(c, c % 17);
    expect_round_trip(*encoder, mask);
  }
}

TEST(PngEncoder, WritesTheSameBytesForTheSameMask) {
  auto one = PngEncoder::for_masks(500, 300), other = PngEncoder::for_masks(1440, 2560);
  ASSERT_TRUE(one.has_value() && other.has_value());
  Mask mask(500, 300);
  for (std::uint32_t r = 20; r < 250; ++r) {
    for (std::uint32_t c = r / 2; c < r; ++c) mask.image.set(c, r);
  }
  const auto a = one->encode(mask.image), b = other->encode(mask.image);
  EXPECT_TRUE(std::equal(a.begin(), a.end(), b.begin(), b.end()));
}

TEST(PngEncoder, IgnoresBitsPastTheLastColumn) {
  auto encoder = PngEncoder::for_masks(70, 2);
  ASSERT_TRUE(encoder.has_value());
  Mask clean(70, 2), dirty(70, 2);
  for (auto& word : dirty.words) word = 0;
  dirty.words[1] = dirty.words[3] = ~dirty.image.last_word_mask();
  const auto a = encoder->encode(clean.image);
  const std::vector<std::byte> kept(a.begin(), a.end());
  const auto b = encoder->encode(dirty.image);
  EXPECT_TRUE(std::equal(kept.begin(), kept.end(), b.begin(), b.end()));
}

TEST(PngEncoder, HasTheLevelsOfGreyPixels) {
  for (const std::uint32_t columns : {70U, 128U}) {
    auto encoder = PngEncoder::for_masks(columns, 5, MaskDepth::kNeeded);
    ASSERT_TRUE(encoder.has_value());
    Mask mask(columns, 5);
    for (std::uint32_t c = 10; c < 69; ++c) mask.image.set(c, 2);
    expect_round_trip(*encoder, mask);  // as bits
    // At the start and the end of a row, on white and on black, and two that touch.
    const std::vector<GreyRun> greys = {{0, 1, 1},
                                        {2 * columns + 8, 3, 90},
                                        {2 * columns + 11, 2, 254},
                                        {3 * columns - 1, 1, 7},
                                        {4 * columns + 60, 10, 128}};
    std::vector<unsigned char> expected(std::size_t{5} * columns);
    for (std::uint32_t c = 10; c < 69; ++c) expected[2 * columns + c] = 255;
    for (const GreyRun& run : greys) std::fill_n(&expected[run.pixel], run.count, run.level);
    for (const MaskDepth depth : {MaskDepth::kNeeded, MaskDepth::kByte}) {
      encoder = PngEncoder::for_masks(columns, 5, depth);
      ASSERT_TRUE(encoder.has_value());
      const Decoded decoded = decode(encoder->encode(mask.image, greys), LCT_GREY);
      EXPECT_EQ(decoded.bytes, expected);
      EXPECT_EQ(decoded.type, LCT_GREY);
      EXPECT_EQ(decoded.depth, 8U);
    }
    EXPECT_EQ(decode(encoder->encode(mask.image), LCT_GREY).depth, 8U) << "PrusaSlicer reads no other";
  }
}

TEST(PictureEncoder, RoundTripsPictures) {
  std::mt19937_64 dice(3);
  for (const std::uint32_t columns : {1U, 3U, 640U}) {
    auto encoder = PictureEncoder::create(picture_bytes(columns, 41));
    ASSERT_TRUE(encoder.has_value());
    std::vector<std::uint8_t> rgb(std::size_t{3} * columns * 41);
    for (auto& byte : rgb) byte = static_cast<std::uint8_t>(dice());
    const Decoded decoded = decode(encoder->encode(rgb, columns, 41), LCT_RGB);
    EXPECT_EQ(decoded.columns, columns);
    EXPECT_EQ(decoded.rows, 41U);
    EXPECT_EQ(decoded.type, LCT_RGB);
    EXPECT_EQ(decoded.bytes, rgb);
  }
}

/// Noise with a slope, so that no two bytes of a line need be alike.
std::vector<std::uint8_t> pixels_of(std::uint32_t columns, std::uint32_t rows, std::uint32_t channels) {
  std::mt19937 random(columns * 1000 + rows);
  std::vector<std::uint8_t> pixels(std::size_t{channels} * columns * rows);
  for (std::size_t i = 0; i < pixels.size(); ++i) pixels[i] = static_cast<std::uint8_t>(i / 7 + random() % 5);
  return pixels;
}

TEST(PictureDecoder, GivesBackWhatWasEncoded) {
  auto encoder = PictureEncoder::create(picture_bytes(320, 180));
  auto decoder = PictureDecoder::create();
  ASSERT_TRUE(encoder && decoder);
  std::vector<std::uint8_t> out(std::size_t{3} * 320 * 180);
  for (const auto& [columns, rows, channels] :
       {std::tuple(320U, 180U, 3U), {1U, 1U, 3U}, {320U, 1U, 1U}, {1U, 180U, 1U}, {97U, 31U, 3U}}) {
    const auto pixels = pixels_of(columns, rows, channels);
    const auto size = decoder->decode(encoder->encode(pixels, columns, rows, channels), channels, {320, 180}, out);
    ASSERT_TRUE(size) << size.error().message();
    EXPECT_EQ(std::pair(size->columns, size->rows), std::pair(columns, rows));
    EXPECT_TRUE(std::equal(pixels.begin(), pixels.end(), out.begin()));
  }
}

TEST(PictureDecoder, RefusesWhatIsTooLargeOrDamagedAndWritesNothingBeyondItsRoom) {
  auto encoder = PictureEncoder::create(picture_bytes(40, 20));
  auto decoder = PictureDecoder::create();
  ASSERT_TRUE(encoder && decoder);
  const auto encoded = encoder->encode(pixels_of(40, 20, 3), 40, 20, 3);
  const std::vector<std::byte> file(encoded.begin(), encoded.end());
  std::vector<std::uint8_t> out(std::size_t{3} * 40 * 20);
  const auto code = [&](std::span<const std::byte> bytes, std::uint32_t channels, PngSize most,
                        std::span<std::uint8_t> room) {
    const auto size = decoder->decode(bytes, channels, most, room);
    return size ? std::optional<ErrorCode>() : size.error().code();
  };
  EXPECT_EQ(code(file, 3, {40, 20}, out), std::nullopt);
  EXPECT_EQ(code(file, 3, {39, 20}, out), ErrorCode::kUnsupported);
  EXPECT_EQ(code(file, 3, {40, 19}, out), ErrorCode::kUnsupported);
  EXPECT_EQ(code(file, 3, {40, 20}, std::span(out).first(out.size() - 1)), ErrorCode::kUnsupported);
  EXPECT_EQ(code(file, 1, {40, 20}, out), ErrorCode::kMalformed);
  for (std::size_t size = 0; size < file.size(); ++size) {
    EXPECT_EQ(code(std::span(file).first(size), 3, {40, 20}, out), ErrorCode::kMalformed) << size;
  }
  // Any byte may be wrong: memory checkers see whether that is safe.
  std::mt19937 random(5);
  for (std::size_t at = 0; at < file.size(); ++at) {
    auto damaged = file;
    damaged[at] ^= static_cast<std::byte>(1 + random() % 255);
    static_cast<void>(code(damaged, 3, {40, 20}, out));
  }
}

}  // namespace png_test
}  // namespace plumbline::firmware
