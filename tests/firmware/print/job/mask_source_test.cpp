#include "firmware/print/job/mask_source.hpp"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <array>
#include <vector>

#include "firmware/io/mask_hash.hpp"
#include "firmware/print/job/mask_renderer.hpp"
#include "slicer/core/bit_spans.hpp"

namespace plumbline::firmware {
namespace {

using namespace std::chrono_literals;

using ::testing::HasSubstr;

/// Draws a pixel for each layer: the one that its number says.
class PixelDecoder final : public LayerDecoder {
 public:
  Status decode(int /*file*/, std::string_view /*name*/, const ArchiveLayer& layer, const MaskTurn& /*turn*/,
                BitImage out, GreyRuns& greys) override {
    out.clear();
    out.set(static_cast<std::uint32_t>(layer.number), 0);
    greys.clear();
    if (grey_level > 0) greys.add(70, grey_level);
    return {};
  }
  std::uint8_t grey_level = 0;
};

std::uint64_t hash_of_pixel(std::uint32_t column) {
  std::vector<std::uint64_t> words(BitImage::words_needed(64, 8));
  BitImage image(words, 64, 8);
  image.clear();
  image.set(column, 0);
  return mask_hash(image);
}

TEST(ArchiveMasks, ShowsNoMaskButTheOneThatWasChecked) {
  const std::array<ArchiveLayer, 3> layers = {ArchiveLayer{{}, 5, hash_of_pixel(5)},
                                              ArchiveLayer{{}, 6, hash_of_pixel(5)},  // replaced since
                                              ArchiveLayer{{}, 7, hash_of_pixel(7)}};
  PrintGrid grid;
  grid.columns = 64;
  grid.rows = 8;
  grid.layers = 3;
  std::vector<std::byte> block(1 << 16U);
  Arena arena{std::span(block)};
  PixelDecoder decoder;
  auto masks = ArchiveMasks::create(-1, "part.sl1", grid, layers, {}, decoder, true, arena);
  ASSERT_TRUE(masks);
  EXPECT_TRUE(masks->mask(0));
  const auto changed = masks->mask(1);
  ASSERT_FALSE(changed);
  EXPECT_EQ(changed.error().code(), ErrorCode::kMalformed);
  EXPECT_THAT(changed.error().message(), HasSubstr("part.sl1: layer 2 is not as it was when the print was checked"));
  EXPECT_TRUE(masks->mask(2));
  EXPECT_TRUE(masks->greys().empty());
  decoder.grey_level = 100;
  EXPECT_FALSE(masks->mask(2)) << "its greys have changed";
}

TEST(MaskRenderer, GivesThePanelTheGreysOfItsSource) {
  PrintGrid grid;
  grid.columns = 64;
  grid.rows = 8;
  grid.layers = 1;
  grid.pitch_x_mm = grid.pitch_y_mm = grid.layer_height_mm = 0.05F;
  std::vector<std::byte> block(1 << 16U);
  Arena arena{std::span(block)};
  PixelDecoder decoder;
  decoder.grey_level = 90;
  const GreyRun run{70, 1, 90};
  std::vector<std::uint64_t> words(BitImage::words_needed(64, 8));
  const BitImage image(words, 64, 8);
  image.set(5, 0);
  const std::uint64_t hash = mask_hash(image, std::span(&run, 1));
  const std::array<ArchiveLayer, 1> layers = {ArchiveLayer{{}, 5, hash}};
  auto masks = ArchiveMasks::create(-1, "part.sl1", grid, layers, {}, decoder, true, arena);
  ASSERT_TRUE(masks);
  PrintPlan plan;
  plan.layers = 1;
  auto renderer = MaskRenderer::create(*masks, plan, arena);
  ASSERT_TRUE(renderer);
  std::vector<GreyRun> room(4);
  GreyRuns greys(room, 64);
  const auto facts = renderer->render(0, {}, image, greys);
  ASSERT_TRUE(facts) << facts.error().message();
  EXPECT_THAT(greys.runs(), ::testing::ElementsAre(run));
  EXPECT_EQ(facts->hash, hash);
  EXPECT_EQ(facts->pixels, 1U);
}

/// A square with a grey rim, which counts how often it is asked for.
class GreySquare final : public MaskSource {
 public:
  /// @param run  pixels of a run
  explicit GreySquare(std::uint32_t run = 1) {
    grid_.columns = 64;
    grid_.rows = 32;
    grid_.layers = 3;
    grid_.pitch_x_mm = grid_.pitch_y_mm = grid_.layer_height_mm = 0.05F;
    words_.resize(BitImage::words_needed(64, 32));
    for (std::uint32_t row = 4; row < 28; ++row) {
      fill(image(), row, 10, 50, true);
      for (std::uint32_t k = 0; k < 8; k += run) {
        runs_.push_back(
            {64 * row + 50 + k, static_cast<std::uint16_t>(run), static_cast<std::uint8_t>(255 * (k + 0.5) / 8)});
      }
    }
    set_bits(runs_, image());
  }
  const PrintGrid& grid() const override { return grid_; }
  Expected<ConstBitImage> mask(std::uint32_t /*layer*/) override {
    ++asked;
    return ConstBitImage(image());
  }
  std::span<const GreyRun> greys() const override { return runs_; }
  BitImage image() { return {words_, 64, 32}; }

  int asked = 0;

 private:
  PrintGrid grid_;
  std::vector<std::uint64_t> words_;
  std::vector<GreyRun> runs_;
};

TEST(MaskRenderer, DrawsTheMaskOfEachExposure) {
  GreySquare source;
  std::vector<std::byte> block(1 << 16U);
  Arena arena{std::span(block)};
  PrintPlan plan;
  plan.layers = 3;
  plan.exposure = std::chrono::milliseconds(800);
  plan.initial_exposure = std::chrono::seconds(5);
  plan.bottom_layers = 1;
  plan.elephant_foot = Distance::millimetres(0.1);
  plan.grey_exposures = 3;
  auto renderer = MaskRenderer::create(source, plan, arena);
  ASSERT_TRUE(renderer);
  std::vector<std::uint64_t> words(BitImage::words_needed(64, 32));
  const BitImage image(words, 64, 32);
  GreyRuns none;
  for (const std::uint32_t layer : {0U, 1U}) {
    std::vector<std::chrono::nanoseconds> light(64 * 32);
    std::chrono::nanoseconds lit{};
    for (std::uint32_t exposure = 0;; ++exposure) {
      const auto facts = renderer->render(layer, lit, image, none);
      ASSERT_TRUE(facts);
      EXPECT_EQ(facts->exposure, exposure);
      EXPECT_EQ(facts->begin, lit);
      EXPECT_EQ(facts->hash, mask_hash(source.image(), source.greys())) << "the layer's own";
      EXPECT_EQ(facts->pixels, ConstBitImage(source.image()).count());
      EXPECT_TRUE(std::ranges::equal(renderer->mask().words(), source.image().words()));
      for (std::uint32_t pixel = 0; pixel < light.size(); ++pixel) {
        if (image.at(pixel % 64, pixel / 64)) light[pixel] += facts->end - lit;
      }
      lit = facts->end;
      if (facts->is_last) break;
    }
    EXPECT_EQ(lit, exposure_of(plan, layer));
    const auto of = [&](std::uint32_t column, std::uint32_t row) { return light[64 * row + column]; };
    EXPECT_EQ(of(30, 15), exposure_of(plan, layer)) << "white, and within the outline";
    EXPECT_EQ(of(10, 15), plan.exposure) << "the outline";
    EXPECT_EQ(of(9, 15), std::chrono::nanoseconds());
    for (const GreyRun& run : source.greys().first(8)) {
      if (layer == 0) continue;
      EXPECT_EQ(of(run.pixel % 64, 4), plan.exposure * share_of(run.level, 3) / 8) << +run.level;
    }
  }
  EXPECT_EQ(source.asked, 2) << "once a layer";
}

TEST(MaskRenderer, ShowsEachStripOfATestWithItsGreys) {
  for (const std::uint32_t run : {1U, 4U, 8U}) {
    GreySquare source(run);  // white from column 10 to 50, then grey up to 58
    std::vector<std::byte> block(1 << 16U);
    Arena arena{std::span(block)};
    PrintPlan plan;
    plan.layers = 3;
    plan.test = {.count = 3, .exposures = {1s, 2s, 4s}, .begin = 22, .end = 70};  // from columns 0, 38 and 54 on
    plan.exposure = 4s;
    auto renderer = MaskRenderer::create(source, plan, arena);
    ASSERT_TRUE(renderer);
    std::vector<std::uint64_t> words(BitImage::words_needed(64, 32));
    const BitImage image(words, 64, 32);
    std::vector<GreyRun> room(1000);
    std::vector<double> light(64 * 32);
    std::chrono::nanoseconds lit{};
    for (bool is_last = false; !is_last;) {
      GreyRuns greys(room, 64);
      const auto facts = renderer->render(1, lit, image, greys);
      ASSERT_TRUE(facts);
      is_last = facts->is_last;
      const double seconds = std::chrono::duration<double>(facts->end - lit).count();
      lit = facts->end;
      std::vector<std::uint32_t> level(light.size());
      for (std::uint32_t i = 0; i < level.size(); ++i) level[i] = image.at(i % 64, i / 64) ? 255 : 0;
      for (const GreyRun& grey : greys.runs()) std::fill_n(level.begin() + grey.pixel, grey.count, grey.level);
      for (std::uint32_t i = 0; i < level.size(); ++i) light[i] += seconds * level[i] / 255;
    }
    EXPECT_EQ(lit, 4s);
    const auto of = [&](std::uint32_t column) { return light[64 * 15 + column]; };
    const auto share = [&](std::uint32_t k) { return std::floor(255 * (k / run * run + 0.5) / 8) / 255; };
    EXPECT_EQ(of(9), 0);
    for (std::uint32_t column = 10; column < 58; ++column) {
      const double full = column < 38 ? 1 : column < 54 ? 2 : 4;
      EXPECT_NEAR(of(column), full * (column < 50 ? 1 : share(column - 50)), 1e-9) << column << " in runs of " << run;
    }
    EXPECT_EQ(of(58), 0);
  }
}

}  // namespace
}  // namespace plumbline::firmware
