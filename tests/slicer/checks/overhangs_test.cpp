#include "slicer/checks/overhangs.hpp"

#include <gtest/gtest.h>

#include "tests/slicer/support/pixels.hpp"
#include "tests/slicer/support/surfaces.hpp"

namespace plumbline {
namespace {

using namespace testing;

/// A pixel stays if all pixels of the plus round it are white or outside of the box.
Pixels eroded_by_definition(const Pixels& fresh, const RegionBox& box, int reach) {
  Pixels out(fresh.columns(), fresh.rows());
  const auto fits = [&](int c, int r) {
    const bool outside = c < static_cast<int>(box.column) || c >= static_cast<int>(box.column_end) ||
                         r < static_cast<int>(box.row) || r >= static_cast<int>(box.row_end);
    return outside || fresh.at(c, r);
  };
  for (int r = 0; r < static_cast<int>(fresh.rows()); ++r) {
    for (int c = 0; c < static_cast<int>(fresh.columns()); ++c) {
      bool stays = fresh.at(c, r);
      for (int d = -reach; d <= reach; ++d) stays = stays && fits(c + d, r) && fits(c, r + d);
      out.set(static_cast<std::uint32_t>(c), static_cast<std::uint32_t>(r), stays);
    }
  }
  return out;
}

TEST(ErodeFresh, IsThatOfItsDefinition) {
  Random random(9);
  for (int i = 0; i < 300; ++i) {
    const std::uint32_t columns = 1 + random.below(200);
    const std::uint32_t rows = 1 + random.below(60);
    RegionBox box;
    box.column = random.below(columns);
    box.column_end = box.column + 1 + random.below(columns - box.column);
    box.row = random.below(rows);
    box.row_end = box.row + 1 + random.below(rows - box.row);
    Pixels fresh(columns, rows);
    const std::uint32_t holes = 1 + random.below(200);
    for (std::uint32_t r = box.row; r < box.row_end; ++r) {
      for (std::uint32_t c = box.column; c < box.column_end; ++c) fresh.set(c, r, random.below(holes) != 0);
    }
    const std::uint32_t reach = random.below(12);
    OwnedImage out(columns, rows);
    const auto left = erode_fresh(fresh.image().view(), box, reach, out.view());
    const Pixels expected = eroded_by_definition(fresh, box, static_cast<int>(reach));
    EXPECT_EQ(Pixels(out.view()), expected) << columns << " x " << rows << ", reach " << reach;
    EXPECT_EQ(left, expected.count());
    EXPECT_TRUE(out.clear_past_the_last_column());
  }
}

}  // namespace
}  // namespace plumbline
