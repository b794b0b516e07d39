#include "firmware/pictures/issue_picture.hpp"

#include <gtest/gtest.h>

#include <algorithm>
#include <cstdint>
#include <vector>

#include "firmware/pictures/preview/preview.hpp"
#include "tests/slicer/support/solid.hpp"

namespace plumbline::firmware {
namespace {

using namespace testing;

/// Columns and rows of a picture, half-open.
struct Part {
  std::uint32_t left, right, top, bottom;
};
constexpr Part kBesideTiles{0, 330, 100, 800};
/// Of the tiles beside the overview, by place.
constexpr Part tile(std::uint32_t place) {
  const std::uint32_t left = 344 + place % 3 * 408, top = 100 + place / 3 * 390;
  return {left, left + 380, top, top + 300};
}

struct IssuesPage {
  IssuesPage(const StackFindings& findings, const RRep& rrep) : memory(64U << 20U), rgb(kPageBytes), arena(memory) {
    EXPECT_TRUE(draw_issues(findings, rrep, {}, "walls", arena, rgb).has_value());
    EXPECT_EQ(arena.used(), 0U);
  }
  bool red(std::uint32_t column, std::uint32_t row) const {
    const std::uint8_t* const pixel = &rgb[3 * (std::size_t{row} * kPreviewColumns + column)];
    return pixel[0] > 200 && pixel[1] < 120 && pixel[2] < 100;
  }
  bool bright(std::uint32_t column, std::uint32_t row) const {
    const std::uint8_t* const pixel = &rgb[3 * (std::size_t{row} * kPreviewColumns + column)];
    return pixel[0] > 110 && pixel[1] > 100;
  }
  /// The least box of pixels of a part that `counts` counts, and how many these are.
  template <class Counts>
  std::pair<Part, int> box(const Part& part, Counts counts) const {
    Part box{part.right, part.left, part.bottom, part.top};
    int count = 0;
    for (std::uint32_t row = part.top; row < part.bottom; ++row) {
      for (std::uint32_t column = part.left; column < part.right; ++column) {
        if (!counts(column, row)) continue;
        box = {std::min(box.left, column), std::max(box.right, column + 1), std::min(box.top, row),
               std::max(box.bottom, row + 1)};
        ++count;
      }
    }
    return {box, count};
  }
  std::pair<Part, int> reds(const Part& part) const {
    return box(part, [this](std::uint32_t column, std::uint32_t row) { return red(column, row); });
  }

  std::vector<std::byte> memory;
  std::vector<std::uint8_t> rgb;
  Arena arena;
};

/// A wall of 10 x 4 x 20 mm, with a piece of 1 mm in the air on its upper right.
struct Walls {
  static constexpr PrintGrid kGrid{200, 120, 200, 0.1F, 0.1F, 0.1F};
  Solid solid{kGrid, blocks({{20, 120, 40, 80, 0, 200}, {150, 160, 50, 60, 150, 160}})};
  static constexpr Issue kIsland{.kind = IssueKind::kIsland,
                                 .layer = 150,
                                 .first_layer = 150,
                                 .last_layer = 150,
                                 .column = 155,
                                 .row = 55,
                                 .pixels = 100,
                                 .voxels = 100};

  static StackFindings findings(std::initializer_list<Issue> issues) {
    StackFindings found;
    for (const Issue& issue : issues) found.groups[static_cast<std::size_t>(issue.kind)].add(issue);
    return found;
  }
};

TEST(IssuesPage, MarksTheIssueInItsTileAndInAnOverview) {
  const Walls walls;
  const IssuesPage page(Walls::findings({Walls::kIsland}), walls.solid.rrep);
  const auto [object, shown] = page.box(kBesideTiles, [&](std::uint32_t column, std::uint32_t row) {
    return page.bright(column, row) || page.red(column, row);
  });
  // From the front, without the line that it stands on: 14 of 20 mm.
  EXPECT_NEAR((object.right - object.left) / 14.0, (object.bottom - object.top) / 20.0, 1.5);
  EXPECT_GT(object.right - object.left, 200U);
  const auto [mark, reds] = page.reds(kBesideTiles);
  EXPECT_GT(reds, 200);
  EXPECT_LT(reds, 400);
  EXPECT_EQ(mark.right - mark.left, mark.bottom - mark.top) << "a disc";
  const double column = (mark.left + mark.right) / 2.0, row = (mark.top + mark.bottom) / 2.0;
  EXPECT_NEAR((column - object.left) / (object.right - object.left), 13.5 / 14, 0.05);
  EXPECT_NEAR((object.bottom - row) / (object.bottom - object.top), 15.0 / 20, 0.05);
  // The tile has its number and the issue, which takes a good part of it.
  EXPECT_GT(page.reds(tile(0)).second, 3000);
  EXPECT_EQ(page.reds(tile(1)).second, 0);
}

TEST(IssuesPage, KeepsMarksOfOnePlaceApart) {
  const Walls walls;
  Issue piece = Walls::kIsland;
  piece.kind = IssueKind::kFreePiece;
  const IssuesPage one(Walls::findings({Walls::kIsland}), walls.solid.rrep);
  const IssuesPage two(Walls::findings({Walls::kIsland, piece}), walls.solid.rrep);
  EXPECT_NEAR(two.reds(kBesideTiles).second, 2 * one.reds(kBesideTiles).second, 100);
  EXPECT_GT(two.reds(tile(1)).second, 3000);
}

TEST(IssuesPage, ShowsASmallOverhangOfALargeLayerFromNear) {
  // From layer 100 on the block has 1 x 1 mm more.
  const Solid leaning(Walls::kGrid, blocks({{20, 170, 10, 110, 0, 120}, {170, 180, 50, 60, 100, 120}}));
  const Issue overhang{.kind = IssueKind::kOverhang,
                       .layer = 100,
                       .first_layer = 100,
                       .last_layer = 100,
                       .column = 175,
                       .row = 55,
                       .pixels = 100,
                       .voxels = 100};
  const IssuesPage page(Walls::findings({overhang}), leaning.rrep);
  EXPECT_GT(page.reds(tile(0)).second, 30 * 30 + 300) << "a tenth of the tile's height, and the number";
}

}  // namespace
}  // namespace plumbline::firmware
