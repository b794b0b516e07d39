/// Shapes whose end on a printer is known.

#include "hal/sim/part/hanging_part.hpp"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <cmath>
#include <functional>
#include <numbers>
#include <vector>

namespace plumbline {
namespace {

using testing::IsEmpty;
using testing::SizeIs;

constexpr double kPitch = 0.1;
constexpr double kHeight = 0.05;

/// Prints a solid that a formula gives, on 20 mm x 20 mm of panel.
class Bench {
 public:
  static constexpr std::uint32_t kSide = 200;
  /// x and y from the panel's middle, z from the plate, mm: the pixel's middle, at half of the layer.
  using Solid = std::function<bool(double x, double y, double z)>;

  explicit Bench(const PeelSettings& peel = {})
      : part({.columns = kSide,
              .rows = kSide,
              .pitch_x_mm = kPitch,
              .pitch_y_mm = kPitch,
              .peel = peel,
              .remember = true}) {
    part.begin(false);
  }

  void print(const Solid& solid, double up_to_mm) {
    const auto layers = static_cast<std::uint32_t>(std::lround(up_to_mm / kHeight));
    while (layers_.size() < layers) {
      const auto k = static_cast<std::uint32_t>(layers_.size());
      std::vector<std::uint64_t> asked(BitImage::words_needed(kSide, kSide), 0);
      const BitImage image(asked, kSide, kSide);
      for (std::uint32_t y = 0; y < kSide; ++y) {
        for (std::uint32_t x = 0; x < kSide; ++x) {
          if (solid((x + 0.5) * kPitch - 10, (y + 0.5) * kPitch - 10, (k + 0.5) * kHeight)) image.set(x, y);
        }
      }
      std::vector<std::uint64_t> lit = asked;
      for (std::size_t i = 0; i < lit.size(); ++i) lit[i] &= ~part.film().words()[i];
      part.add_layer(k, kHeight, 0.12, BitImage(lit, kSide, kSide), image);
      layers_.push_back(lit);
    }
  }
  /// Volume that stayed, ml.
  double stayed_ml() {
    std::uint64_t pixels = 0;
    for (std::size_t k = 0; k < layers_.size(); ++k) {
      std::vector<std::uint64_t> words = layers_[k];
      const BitImage image(words, kSide, kSide);
      part.remove_lost(k, image);
      pixels += image.count();
    }
    return static_cast<double>(pixels) * kPitch * kPitch * kHeight / 1000;
  }

  HangingPart part;

 private:
  std::vector<std::vector<std::uint64_t>> layers_;
};

double radius(double x, double y) { return std::sqrt(x * x + y * y); }

TEST(HangingPart, KeepsACantilever) {
  // A post with an arm: the arm is joined to the post at its side, so it is held. Droop is not modelled.
  Bench bench;
  bench.print([](double x, double y, double z) { return std::abs(y) < 2 && x > -8 && (x < -4 || (z > 3 && x < 8)); },
              4);
  EXPECT_THAT(bench.part.losses(), IsEmpty());
}

TEST(HangingPart, DropsAMushroomsBrimUntilItMeetsTheStem) {
  // A cap whose brim hangs lower than its middle. The brim begins in layer 40 as a ring that touches nothing.
  Bench bench;
  const auto solid = [](double x, double y, double z) {
    const double r = radius(x, y);
    return r < 2 || (r < 8 && z > 3) || (r > 6 && r < 8 && z > 2);
  };
  bench.print(solid, 4);
  const auto losses = bench.part.losses();
  ASSERT_THAT(losses, SizeIs(2));
  EXPECT_EQ(losses[0].kind, LossKind::kDropped);
  EXPECT_EQ(losses[0].layer, 40U);
  EXPECT_EQ(losses[0].last_layer, 59U);
  const double ring_mm2 = std::numbers::pi * (64 - 36);
  EXPECT_NEAR(losses[0].ml, ring_mm2 * 1 / 1000, 0.002 * ring_mm2 / 1000);
  EXPECT_NEAR(static_cast<double>(losses[0].pixels) * kPitch * kPitch, ring_mm2, 0.002 * ring_mm2);
  // It stays on the film, so the cap above it is not cured either.
  EXPECT_EQ(losses[1].kind, LossKind::kShadowed);
  EXPECT_EQ(losses[1].layer, 60U);
  EXPECT_EQ(losses[1].last_layer, 79U);
  EXPECT_NEAR(losses[1].ml, losses[0].ml, 1e-9);
}

TEST(HangingPart, LeavesNoShadowOnACleanedFilm) {
  Bench bench;
  const auto table = [](double x, double, double z) {
    return std::abs(x + 5) < 2 || (z > 1 && z < 2 && x > 0) || z > 3;
  };
  bench.print(table, 2.5);
  ASSERT_THAT(bench.part.losses(), SizeIs(1));
  EXPECT_FALSE(bench.part.film_is_clean());
  bench.part.clean_film();
  bench.print(table, 4);
  EXPECT_THAT(bench.part.losses(), SizeIs(1));
  EXPECT_TRUE(bench.part.film_is_clean());
}

TEST(HangingPart, TearsAThinNeckBelowAWideDisc) {
  // A disc of 8 mm radius on a neck of 0.2 mm between two cones. It pulls with s pi r^2 + g 2 pi r.
  const PeelSettings peel;
  const double asked = peel.force(std::numbers::pi * 64, 2 * std::numbers::pi * 8, 0);
  for (const double factor : {0.8, 1.2}) {
    const double neck = std::sqrt(asked * factor / peel.green_strength_mpa / std::numbers::pi);
    const auto solid = [&](double x, double y, double z) {
      return radius(x, y) < (z > 3 ? 8 : neck + 4 * std::max(0.0, std::abs(z - 1) - 0.1));
    };
    Bench bench;
    bench.print(solid, 4);
    const auto losses = bench.part.losses();
    if (factor > 1) {
      EXPECT_THAT(losses, IsEmpty());
      continue;
    }
    // The cone already tears off when its disc is as wide as the neck holds; the rest of the column has nothing to hang from.
    ASSERT_THAT(losses, SizeIs(1));
    EXPECT_EQ(losses[0].kind, LossKind::kTorn);
    EXPECT_NEAR(losses[0].layer, 20, 3) << "in the neck";
    EXPECT_GT(losses[0].asked_n, losses[0].held_n);
    EXPECT_NEAR(losses[0].held_n, asked * factor, 0.15 * asked) << "a few pixels of neck more or less";
    Bench whole;
    whole.part.begin(true);
    std::uint64_t below = 0;
    for (std::uint32_t k = losses[0].layer; k < 80; ++k) {
      for (int j = 0; j < 200; ++j) {
        for (int i = 0; i < 200; ++i) {
          below += solid((i + 0.5) * kPitch - 10, (j + 0.5) * kPitch - 10, (k + 0.5) * kHeight) ? 1 : 0;
        }
      }
    }
    EXPECT_NEAR(losses[0].ml, static_cast<double>(below) * kPitch * kPitch * kHeight / 1000, 1e-9);
    EXPECT_EQ(losses[0].last_layer, 79U);
    EXPECT_LT(bench.stayed_ml(), 0.2 * losses[0].ml);
  }
}

TEST(HangingPart, TearsFromThePlateIfTheFirstLayerIsTooSmall) {
  // A cone on its tip.
  Bench bench;
  bench.print([](double x, double y, double z) { return radius(x, y) < 0.3 + 2 * z; }, 3);
  const auto losses = bench.part.losses();
  ASSERT_THAT(losses, SizeIs(1));
  EXPECT_EQ(losses[0].kind, LossKind::kTorn);
  EXPECT_EQ(losses[0].layer, 0U);
  EXPECT_EQ(bench.stayed_ml(), 0);
}

TEST(HangingPart, FeelsTheSuctionOfACupUntilItIsVented) {
  // A cup upside down on the plate's side: a floor of 1 mm, then a wall. With a hole through the wall from 2 to 2.5 mm.
  const auto cup = [](bool vented) {
    return [vented](double x, double y, double z) {
      const double r = radius(x, y);
      if (vented && std::abs(y) < 0.5 && x > 0 && z > 2 && z < 2.5) return r < 5;
      return r < 7 && (z < 1 || r > 6 || r < 0);
    };
  };
  PeelSettings peel;
  const double ring = peel.force(std::numbers::pi * (49 - 36), 2 * std::numbers::pi * (7 + 6), 0);
  const double mouth = std::numbers::pi * 36;
  Bench sealed;
  sealed.print(cup(false), 3);
  EXPECT_THAT(sealed.part.losses(), IsEmpty());
  EXPECT_NEAR(sealed.part.suction_mm2(), mouth, 0.005 * mouth);
  EXPECT_NEAR(sealed.part.peel_n(), ring + 1e-3 * peel.suction_kpa * mouth, 0.02 * ring);
  EXPECT_EQ(sealed.part.cavities().trapped_mm3(), 0) << "it is open";
  Bench vented;
  vented.print(
      [](double x, double y, double z) {
        const double r = radius(x, y);
        const bool hole = std::abs(y) < 0.5 && x > 0 && z > 2 && z < 2.5;
        return r < 7 && (z < 1 || (r > 6 && !hole));
      },
      3);
  EXPECT_EQ(vented.part.suction_mm2(), 0);
  EXPECT_NEAR(vented.part.peel_n(), ring, 0.02 * ring);
}

TEST(HangingPart, TearsWhereACupSucks) {
  // A cup on a stem that holds its wall, but not the suction.
  const PeelSettings peel;
  const double wall = peel.force(std::numbers::pi * (49 - 36), 2 * std::numbers::pi * (7 + 6), 0);
  const double floor = peel.force(std::numbers::pi * 49, 2 * std::numbers::pi * 7, 0);
  const double suction = 1e-3 * peel.suction_kpa * std::numbers::pi * 36;
  const double holds = std::max(wall, floor) + 0.3 * suction;
  const double stem = std::sqrt(holds / peel.green_strength_mpa / std::numbers::pi);
  for (const bool sealed : {false, true}) {
    Bench bench;
    bench.print(
        [&](double x, double y, double z) {
          const double r = radius(x, y);
          if (z < 1) return r < 4;
          if (z < 2) return r < stem;
          return r < 7 && (z < 3 || r > 6) && (sealed || std::abs(y) > 0.3 || z < 3);
        },
        4);
    ASSERT_THAT(bench.part.losses(), SizeIs(sealed ? 1 : 0));
    if (sealed) {
      EXPECT_EQ(bench.part.losses()[0].kind, LossKind::kTorn);
    }
  }
}

TEST(HangingPart, LetsTheWallOfACupCarryItsSuctionAndNothingWithin) {
  // A bar to the left of the cavity's widest row, on a neck that holds 2 N: enough for its own peel of 0.4 N, but not for a suction
  // of 2.3 N.
  Bench bench;
  bench.print(
      [&](double x, double y, double z) {
        const bool bar = std::abs(x + 5) < 0.1 && std::abs(y) < (z < 1.5 ? 1 : 3);
        return radius(x, y) < 7 && (z < 1 || radius(x, y) > 6 || bar);
      },
      3);
  EXPECT_THAT(bench.part.losses(), IsEmpty());
  EXPECT_GT(bench.part.suction_mm2(), 100);
}

TEST(HangingPart, LetsThePlateCarryTheSuctionOfAHoleThatItCloses) {
  // A ring on the plate, so thin that it holds its own peel but not the suction of what it encloses.
  PeelSettings peel;
  const auto ring = [](double x, double y, double) { return radius(x, y) < 8 && radius(x, y) > 7.6; };
  const double area = std::numbers::pi * (64 - 57.76);
  const double outline = 2 * std::numbers::pi * (8 + 7.6);
  const double mouth = std::numbers::pi * 57.76;
  peel.plate_adhesion_mpa = peel.force(area, outline, mouth / 4) / area;
  Bench bench(peel);
  bench.print(ring, 1);
  EXPECT_THAT(bench.part.losses(), IsEmpty());
  EXPECT_NEAR(bench.part.suction_mm2(), mouth, 0.005 * mouth);
  const double peeled = peel.force(area, outline, mouth);
  EXPECT_NEAR(bench.part.peel_n(), peeled, 0.03 * peeled) << "the motor feels it";
}

TEST(HangingPart, LetsTheWallCarryTheSuctionBesideThePlatesShare) {
  // From 1 mm on, a hole of 5 mm radius in a disc of 8 mm on the plate is 7.6 mm wide. The disc is the ceiling of pi (7.6^2 - 5^2), the plate
  // that of the rest. The layer at 1 mm needs so much: with 0.9 of it in the joint above, the wall tears, with 1.1 it does not.
  const double own = PeelSettings{}.force(std::numbers::pi * (64 - 57.76), 2 * std::numbers::pi * (8 + 7.6), 0);
  const double suction = 1e-3 * PeelSettings{}.suction_kpa * std::numbers::pi * (57.76 - 25);
  for (const double factor : {0.9, 1.1}) {
    PeelSettings peel;
    peel.green_strength_mpa = factor * (own + suction) / (std::numbers::pi * (64 - 57.76));
    peel.plate_adhesion_mpa = 5;
    Bench bench(peel);
    bench.print([](double x, double y, double z) { return radius(x, y) < 8 && radius(x, y) > (z < 1 ? 5 : 7.6); }, 2);
    EXPECT_THAT(bench.part.losses(), SizeIs(factor < 1 ? 1 : 0)) << factor;
  }
}

TEST(HangingPart, CountsTheResinInAClosedBall) {
  // A hollow ball, its cavity 4 mm in radius: 4/3 pi r^3.
  const auto ball = [](double hole) {
    return [hole](double x, double y, double z) {
      const double r = std::sqrt(x * x + y * y + (z - 6) * (z - 6));
      if (z < 6 && r > 4 && radius(x, y) < 6) return radius(x, y) > hole || z > 1;  // stands on a solid foot
      return r < 6 && r > 4 && radius(x, y) > hole;
    };
  };
  Bench closed;
  closed.print(ball(-1), 12);
  const double volume = 4 * std::numbers::pi / 3 * 64;
  EXPECT_EQ(closed.part.cavities().traps(), 1U);
  EXPECT_NEAR(closed.part.cavities().trapped_mm3(), volume, 0.005 * volume);
  EXPECT_NEAR(closed.part.cavities().largest_trap().layer * kHeight, 10, 2 * kHeight);
  // A hole through its top drains it when it is turned round; a hole to the plate, when it comes off.
  Bench drained;
  drained.print(ball(1), 12);
  EXPECT_EQ(drained.part.cavities().traps(), 0U);
}

TEST(HangingPart, BleedsTheLightBeyondALayerThatHasNothingAboveIt) {
  Bench bench;
  bench.print([](double x, double, double z) { return x < 0 || z > 1; }, 2);
  // 100 columns of 200 rows, each 0.12 mm - 0.05 mm deeper.
  EXPECT_NEAR(bench.part.bleed_mm3(), 10 * 20 * 0.07, 1e-9);
}

}  // namespace
}  // namespace plumbline
