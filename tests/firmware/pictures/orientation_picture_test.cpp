#include "firmware/pictures/orientation_picture.hpp"

#include <gtest/gtest.h>

#include <algorithm>
#include <array>
#include <memory>
#include <string>
#include <utility>
#include <vector>

#include "firmware/io/file_source.hpp"
#include "firmware/pictures/preview/preview_page.hpp"
#include "firmware/sample/scan_sample.hpp"
#include "slicer/cloud/cloud_reader.hpp"

namespace plumbline::firmware {
namespace {

/// The sample's scan as it is read for a picture: with noise, outliers and flying pixels.
struct ScannedBust {
  explicit ScannedBust(std::uint32_t most) : memory(64U << 20U), arena(memory) {
    const std::string path = ::testing::TempDir() + "bust_of_pictures.ply";
    EXPECT_TRUE(write_bust_scan(path, {.points = 100'000}).has_value());
    auto source = FileSource::open(path);
    EXPECT_TRUE(source.has_value());
    ByteSource* const file = &*source;
    const auto room = [most](const ScanAnnouncement&) -> Expected<std::uint32_t> { return most; };
    const auto read = read_cloud({&file, 1}, {}, room, arena, nullptr);
    EXPECT_TRUE(read.has_value());
    cloud = read->cloud;
  }
  std::vector<std::byte> memory;
  Arena arena;
  Cloud cloud;
};

/// What a picture shows before the usual background.
template <class SmallPicture>
class Silhouette {
 public:
  explicit Silhouette(const SmallPicture& picture) : picture_(picture), ground_(std::make_unique<SmallPicture>()) {
    EXPECT_EQ(picture.columns, SmallPicture::kMostColumns);
    EXPECT_EQ(picture.rows, SmallPicture::kMostRows);
    preview::draw_background({ground_->memory, kColumns, kRows});
    keep_five_bits(ground_->memory);
    for (int y = 0; y < kRows; ++y) {
      for (int x = 0; x < kColumns; ++x) {
        const auto level = [&](const SmallPicture& of, std::size_t c) { return of.memory[at(x, y) * 3 + c]; };
        const auto sum = [&](const SmallPicture& of) { return level(of, 0) + level(of, 1) + level(of, 2); };
        bool same = true;
        for (std::size_t c = 0; c < 3; ++c) same = same && level(picture_, c) == level(*ground_, c);
        shown_.push_back(!same);
        dark_.push_back(!same && sum(picture_) < sum(*ground_));
        orange_.push_back(level(picture_, 0) > 2 * level(picture_, 2));
      }
    }
  }
  std::ptrdiff_t shown() const { return std::ranges::count(shown_, true); }
  std::ptrdiff_t dark() const { return std::ranges::count(dark_, true); }
  std::ptrdiff_t orange() const { return std::ranges::count(orange_, true); }
  /// Pieces of the object: those that touch at a corner are one.
  int pieces() const { return count_pieces(shown_, true, false); }
  /// Pieces of background that the object encloses.
  int holes() const { return count_pieces(shown_, false, true); }
  /// Larger share of the picture's sides that the object takes.
  double filled() const {
    int left = kColumns, right = -1, top = kRows, bottom = -1;
    for (int y = 0; y < kRows; ++y) {
      for (int x = 0; x < kColumns; ++x) {
        if (!shown_[at(x, y)]) continue;
        left = std::min(left, x), right = std::max(right, x), top = std::min(top, y), bottom = std::max(bottom, y);
      }
    }
    return std::max((right + 1.0 - left) / kColumns, (bottom + 1.0 - top) / kRows);
  }

 private:
  static constexpr int kColumns = SmallPicture::kMostColumns, kRows = SmallPicture::kMostRows;
  static std::size_t at(int x, int y) { return static_cast<std::size_t>(y * kColumns + x); }

  static int count_pieces(std::vector<bool> pixels, bool of, bool enclosed) {
    int pieces = 0;
    for (int y = 0; y < kRows; ++y) {
      for (int x = 0; x < kColumns; ++x) {
        if (pixels[at(x, y)] != of) continue;
        bool at_rim = false;
        std::vector<std::pair<int, int>> open{{x, y}};
        pixels[at(x, y)] = !of;
        while (!open.empty()) {
          const auto [column, row] = open.back();
          open.pop_back();
          at_rim = at_rim || column == 0 || row == 0 || column == kColumns - 1 || row == kRows - 1;
          for (int i = 0; i < 9; ++i) {
            const int c = column + i % 3 - 1, r = row + i / 3 - 1;
            const bool at_corner = i % 2 == 0;
            if ((at_corner && !of) || c < 0 || r < 0 || c >= kColumns || r >= kRows || pixels[at(c, r)] != of) continue;
            pixels[at(c, r)] = !of;
            open.emplace_back(c, r);
          }
        }
        if (!enclosed || !at_rim) ++pieces;
      }
    }
    return pieces;
  }

  const SmallPicture& picture_;
  std::unique_ptr<SmallPicture> ground_;
  std::vector<bool> shown_, dark_, orange_;
};

TEST(ScanPicture, OfANoisyScanIsOneBrightSurfaceThatFillsIt) {
  ScannedBust bust(1U << 15U);
  const auto picture = std::make_unique<ScanPicture>();
  const std::size_t used = bust.arena.used();
  ASSERT_TRUE(draw_scan_picture(bust.cloud, bust.arena, *picture).has_value());
  EXPECT_EQ(bust.arena.used(), used);
  const Silhouette seen(*picture);
  EXPECT_EQ(seen.pieces(), 1);
  EXPECT_EQ(seen.holes(), 0);
  EXPECT_GT(seen.filled(), 0.93);
  EXPECT_LT(static_cast<double>(seen.dark()), 0.01 * static_cast<double>(seen.shown()));
  EXPECT_GT(static_cast<double>(seen.shown()), 0.3 * picture->columns * picture->rows);
}

TEST(ScanPicture, ShowsAFewPointsThatMakeNoSurface) {
  ScannedBust bust(1U << 15U);
  bust.cloud.size = 5;
  const auto picture = std::make_unique<ScanPicture>();
  ASSERT_TRUE(draw_scan_picture(bust.cloud, bust.arena, *picture).has_value());
  EXPECT_GT(Silhouette(*picture).shown(), 5);
  bust.cloud.size = 1;
  ASSERT_TRUE(draw_scan_picture(bust.cloud, bust.arena, *picture).has_value());
  EXPECT_TRUE(picture->there());
}

TEST(ScanPicture, TakesPointsAtTheEndsOfTheNumbers) {
  ScannedBust bust(1U << 15U);
  bust.cloud.size = 1000;
  for (std::uint32_t i = 0; i < bust.cloud.size; ++i) {
    const float far = i % 2 == 0 ? 3e38F : -3e38F;
    bust.cloud.position[i] = {far, i % 3 == 0 ? far : -far, i % 7 == 0 ? 0.0F : far};
  }
  const auto picture = std::make_unique<ScanPicture>();
  ASSERT_TRUE(draw_scan_picture(bust.cloud, bust.arena, *picture).has_value());
  EXPECT_TRUE(picture->there());
}

TEST(ProposalPictures, ShowOneSurfaceAtOneScaleAndWhatNeedsSupports) {
  ScannedBust bust(100'000);
  const auto pictures = std::make_unique<ProposalPictures>();
  constexpr std::array<std::array<double, 2>, 5> kDegrees{{{0, 0}, {20, 0}, {180, 0}, {30, 0}, {0, 30}}};
  ASSERT_TRUE(draw_proposal_pictures(bust.cloud, kDegrees, bust.arena, *pictures).has_value());
  double most = 0;
  for (const ProposalPicture& picture : *pictures) {
    const Silhouette seen(picture);
    EXPECT_EQ(seen.pieces(), 1);
    EXPECT_EQ(seen.holes(), 0);
    EXPECT_LT(static_cast<double>(seen.dark()), 0.06 * static_cast<double>(seen.shown()));
    most = std::max(most, seen.filled());
  }
  EXPECT_GT(most, 0.95);
  const Silhouette lying((*pictures)[0]), turned((*pictures)[2]);
  EXPECT_NEAR(static_cast<double>(turned.shown()) / static_cast<double>(lying.shown()), 1, 0.03);
  EXPECT_LT(lying.orange(), turned.shown() / 30);
}

}  // namespace
}  // namespace plumbline::firmware
