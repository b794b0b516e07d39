#include "firmware/print/job/mask_source.hpp"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <array>
#include <vector>

#include "firmware/io/mask_hash.hpp"

namespace plumbline::firmware {
namespace {

using ::testing::HasSubstr;

/// Draws a pixel for each layer: the one that its number says.
class PixelDecoder final : public LayerDecoder {
 public:
  Status decode(int /*file*/, std::string_view /*name*/, const ArchiveLayer& layer, const MaskTurn& /*turn*/,
                BitImage out) override {
    out.clear();
    out.set(static_cast<std::uint32_t>(layer.number), 0);
    return {};
  }
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
  auto masks = ArchiveMasks::create(-1, "part.sl1", grid, layers, {}, decoder, arena);
  ASSERT_TRUE(masks);
  EXPECT_TRUE(masks->mask(0));
  const auto changed = masks->mask(1);
  ASSERT_FALSE(changed);
  EXPECT_EQ(changed.error().code(), ErrorCode::kMalformed);
  EXPECT_THAT(changed.error().message(), HasSubstr("part.sl1: layer 2 is not as it was when the print was checked"));
  EXPECT_TRUE(masks->mask(2));
}

}  // namespace
}  // namespace plumbline::firmware
