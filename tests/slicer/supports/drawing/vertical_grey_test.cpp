#include "slicer/supports/drawing/vertical_grey.hpp"

#include <gtest/gtest.h>

#include <cmath>
#include <vector>

#include "slicer/dose/bleed.hpp"
#include "slicer/supports/drawing/mask_stream.hpp"
#include "tests/slicer/support/arena_block.hpp"
#include "tests/slicer/support/columns.hpp"

namespace plumbline {
namespace {

using namespace testing;

/// Light of a column in each layer, 0 to 1: its mask with its grey pixels.
std::vector<std::vector<double>> shares_of(const RRep& rrep, const Supports& supports, const CureModel& model,
                                           Arena& arena) {
  auto stream = value_of(MaskStream::create(rrep, supports, arena));
  auto grey = value_of(VerticalGrey::create(rrep, supports, model, kColumnLayer, arena));
  std::vector<GreyRun> room(1000);
  GreyRuns greys(room, rrep.grid.columns);
  std::vector<std::vector<double>> shares(rrep.grid.columns, std::vector<double>(rrep.grid.layers));
  for (std::uint32_t k = 0; k < rrep.grid.layers; ++k) {
    const ConstBitImage mask = stream.mask(k);
    grey.find(k, stream.section(), mask, greys);
    for (std::uint32_t c = 0; c < rrep.grid.columns; ++c) shares[c][k] = mask.at(c, 0) ? 1 : 0;
    for (const GreyRun& run : greys.runs()) {
      for (std::uint32_t p = run.pixel; p < run.end(); ++p) shares[p][k] = run.level / 255.0;
    }
  }
  return shares;
}

/// Where light in these layers cures down to, in layers, by the definition of CureModel.
double front_of(const CureModel& model, const std::vector<double>& shares) {
  double low = 0, high = 0;
  for (std::uint32_t k = 0; k < shares.size(); ++k) high = shares[k] > 0 && high == 0 ? k + 1 : high;
  for (int i = 0; i < 60; ++i) {
    const double z = (low + high) / 2;
    double sum = 0, largest = 0;
    for (std::uint32_t k = 0; k < shares.size(); ++k) {
      if (k + 1 < z) continue;
      const double dose = shares[k] * model.dose_of(k) * std::exp(-(k + 1 - z) * kColumnLayer / model.penetration_mm);
      sum += dose;
      largest = std::max(largest, dose);
    }
    (largest + (1 - model.exchange) * (sum - largest) >= model.critical_dose ? high : low) = z;
  }
  return high;
}

TEST(VerticalGrey, BringsTheFrontToTheSurface) {
  for (const double exchange : {0.0, 0.4, 1.0}) {
    CureModel model = standard_resin();
    model.exchange = exchange;
    std::vector<std::vector<double>> columns;
    for (double z = 20; z < 24; z += 0.07) columns.insert(columns.end(), {{z, z + 40}, {0, 79}});
    ArenaBlock arena(kMiB);
    RRep rrep = columns_of(columns, 80, *arena);
    value_of(correct_bleed(rrep, model, 0, *arena));
    const auto shares = shares_of(rrep, {}, model, *arena);
    for (std::size_t c = 0; c < columns.size(); c += 2) {
      EXPECT_NEAR(front_of(model, shares[c]), columns[c][0], 0.055) << "3 um; exchange " << exchange;
      EXPECT_EQ(std::ranges::count_if(shares[c], [](double share) { return share > 0 && share < 1; }) <= 1, true);
      for (const double share : shares[c + 1]) EXPECT_TRUE(share == 1 || share == 0) << "it stands on the plate";
    }
  }
}

TEST(VerticalGrey, LeavesTopsBottomLayersAndThinPartsWhite) {
  ArenaBlock arena(kMiB);
  // A top within a layer, an underside among the bottom layers, and one in a part of one layer.
  const RRep rrep = columns_of({{0, 30.3}, {5.3, 40}, {20.4, 21.2}, {20.3, 23}}, 60, *arena);
  const auto shares = shares_of(rrep, {}, standard_resin(), *arena);
  for (const int c : {0, 1, 2}) {
    for (const double share : shares[static_cast<std::size_t>(c)]) EXPECT_TRUE(share == 0 || share == 1) << c;
  }
  EXPECT_NEAR(shares[3][20], grey_of(standard_resin(), kColumnLayer, 0.3), 0.01);
  EXPECT_EQ(shares[3][21], 1);
}

TEST(VerticalGrey, IsWhiteWhereASupportIs) {
  ArenaBlock arena(kMiB);
  const std::vector<std::vector<double>> columns(41, {30.3, 50});
  const RRep rrep = columns_of(columns, 60, *arena);
  const std::vector<Strut> list = {
      {.column0 = 20, .row0 = 0, .column1 = 20, .row1 = 0, .first = 12, .end = 31, .radius0 = 200, .radius1 = 200}};
  const auto shares = shares_of(rrep, Supports{list, PixelPitch(rrep.grid)}, standard_resin(), *arena);
  EXPECT_EQ(shares[20][30], 1);
  EXPECT_LT(shares[2][30], 1);
  EXPECT_GT(shares[2][30], 0);
}

TEST(VerticalGrey, LeavesThePixelsOfAMaskWhiteForThoseWhoReadItFromAFile) {
  std::vector<std::vector<double>> columns;
  for (double z = 20; z < 21; z += 0.02) columns.push_back({z, z + 40});
  ArenaBlock arena(kMiB);
  const RRep rrep = columns_of(columns, 80, *arena);
  auto stream = value_of(MaskStream::create(rrep, {}, *arena));
  auto grey = value_of(VerticalGrey::create(rrep, {}, standard_resin(), kColumnLayer, *arena));
  std::vector<GreyRun> room(1000);
  GreyRuns greys(room, rrep.grid.columns);
  std::uint32_t white = 0, black = 0;
  for (std::uint32_t k = 0; k < rrep.grid.layers; ++k) {
    const ConstBitImage mask = stream.mask(k);
    grey.find(k, stream.section(), mask, greys);
    for (const GreyRun& run : greys.runs()) {
      for (std::uint32_t p = run.pixel; p < run.end(); ++p) {
        const bool is_white = mask.at(p, 0);
        EXPECT_TRUE(!is_white || run.level >= kLeastCuringLevel) << p << " in layer " << k;
        ++(is_white ? white : black);
      }
    }
  }
  EXPECT_GT(white, 15U);
  EXPECT_GT(black, 15U);
}

TEST(VerticalGrey, IsLinearIfTheResinIsNotKnown) {
  EXPECT_EQ(grey_of({}, 0.05, 0.25), 0.75);
  EXPECT_NEAR(grey_of(standard_resin(), 0.05, 0), 1, 1e-12);
  EXPECT_NEAR(grey_of(standard_resin(), 0.05, 1), 0, 2e-3);
}

}  // namespace
}  // namespace plumbline
