#include "firmware/print/job/mask_source.hpp"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <array>
#include <vector>

#include "firmware/io/mask_hash.hpp"
#include "firmware/print/job/mask_renderer.hpp"

namespace plumbline::firmware {
namespace {

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
  const auto facts = renderer->render(0, image, &greys);
  ASSERT_TRUE(facts) << facts.error().message();
  EXPECT_THAT(greys.runs(), ::testing::ElementsAre(run));
  EXPECT_EQ(facts->hash, hash);
  EXPECT_EQ(facts->pixels, 1U);
  // Where the outline of a layer is moved inwards its greys are no longer at the edge.
  plan.elephant_foot = Distance::millimetres(0.05);
  plan.bottom_layers = 1;
  auto smaller = MaskRenderer::create(*masks, plan, arena);
  ASSERT_TRUE(smaller);
  greys.clear();
  ASSERT_TRUE(smaller->render(0, image, &greys));
  EXPECT_TRUE(greys.empty());
  EXPECT_EQ(ConstBitImage(image).count(), 0U);
}

}  // namespace
}  // namespace plumbline::firmware
