#include "firmware/pictures/preview/preview_nearest.hpp"

#include <gtest/gtest.h>

#include <cstdint>
#include <random>
#include <vector>

namespace plumbline::firmware::preview {
namespace {

/// Pixels from the near side of the extent to the first solid one, counted one by one.
std::uint32_t counted_distance(const BitImage& section, const Extent& e, Beside from, std::uint32_t place) {
  std::uint32_t distance = 0;
  const auto is_solid = [&] {
    if (from == Beside::kLeft) return section.at(e.column + distance, place);
    return section.at(place, from == Beside::kFront ? e.row + distance : e.row_end - 1 - distance);
  };
  const std::uint32_t none = from == Beside::kLeft ? e.column_end - e.column : e.row_end - e.row;
  while (distance < none && !is_solid()) ++distance;
  return distance;
}

TEST(NearestSolid, IsTheFirstPixelOfEachLineAfterAnyChanges) {
  constexpr std::uint32_t kColumns = 90, kRows = 70;
  const Extent extent{.column = 5, .column_end = 83, .row = 3, .row_end = 66, .layer = 0, .layer_end = 60};
  for (const Beside from : {Beside::kFront, Beside::kBack, Beside::kLeft}) {
    std::mt19937 random(11);
    const auto dice = [&] { return static_cast<std::uint32_t>(random()); };
    std::vector<std::uint64_t> words(BitImage::words_needed(kColumns, kRows));
    BitImage section(words, kColumns, kRows);
    std::vector<std::uint32_t> distances(kColumns);
    NearestSolid nearest(distances, extent, from);
    for (std::uint32_t layer = 0; layer < extent.layer_end; ++layer) {
      // More and more solid, then less and less.
      for (std::uint32_t change = 0; change < 400; ++change) {
        const std::uint32_t column = extent.column + dice() % (extent.column_end - extent.column);
        const std::uint32_t row = extent.row + dice() % (extent.row_end - extent.row);
        const bool solid = layer < 30 && dice() % 3 == 0;
        if (section.at(column, row) != solid) section.row(row)[column / 64] ^= std::uint64_t{1} << (column % 64);
        if (solid) nearest.add(column, row);
      }
      if (dice() % 3 == 0) continue;  // not every layer is drawn
      nearest.settle(section);
      for (std::uint32_t place = nearest.first(); place < nearest.end(); ++place) {
        ASSERT_EQ(nearest.distances()[place], counted_distance(section, extent, from, place))
            << "layer " << layer << ", line " << place;
      }
    }
  }
}

}  // namespace
}  // namespace plumbline::firmware::preview
