#include "hal/sim/part/dose_field.hpp"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <cmath>
#include <random>

#include "tests/hal/sim/cured_part.hpp"

namespace plumbline {
namespace {

using testing::DoubleNear;
using testing::ElementsAre;

constexpr double kPixelMm = 0.05, kLayerMm = 0.05, kUmInMm = 1e-3;

/// The standard profile: one layer cures 0.121 mm deep.
DoseModel standard_resin(double exchange = 0, double blur = 0.5) {
  return {.resin = {.critical = Dose(3.2), .penetration_mm = 0.12, .exchange = exchange, .blur_px = blur},
          .pitch_x_mm = kPixelMm,
          .pitch_y_mm = kPixelMm};
}
constexpr double kStandardDose = 8.75;

/// How deep `layers` layers cure below the film of the first, if they get kStandardDose each and their doses add up.
double depth_of_layers(int layers) {
  const double fade = std::exp(-kLayerMm / 0.12);
  return 0.12 * std::log(kStandardDose / 3.2 * (1 - std::pow(fade, layers)) / (1 - fade));
}

/// Layers that are white in all pixels from `first` on.
DoseField white_slab(const DoseModel& model, int first, int end, double dose = kStandardDose) {
  DoseField field(model);
  const Mask white(40, 40, [](auto, auto) { return true; });
  for (int k = first; k < end; ++k) field.add(light(k, dose), white.image());
  return field;
}

TEST(DoseField, CuresBelowAFlatUndersideWhatAllLayersAboveItGive) {
  EXPECT_NEAR(depth_of_layers(1), 0.121, 0.0005);
  EXPECT_NEAR(depth_of_layers(1000), 0.250, 0.0005);
  for (const int layers : {1, 2, 40}) {
    EXPECT_THAT(white_slab(standard_resin(), 60, 60 + layers).cured_depths(20, 20),
                ElementsAre(DoubleNear(61 * kLayerMm - depth_of_layers(layers), 0.1 * kUmInMm),
                            DoubleNear((60 + layers) * kLayerMm, 1e-9)));
  }
  // Where each lift brings fresh resin only the first layer's own light counts.
  EXPECT_NEAR(white_slab(standard_resin(1), 60, 100).cured_depths(20, 20)[0], 61 * kLayerMm - depth_of_layers(1), 1e-9);
  const double sum = std::exp(depth_of_layers(40) / 0.12), largest = std::exp(depth_of_layers(1) / 0.12);
  EXPECT_NEAR(white_slab(standard_resin(0.25), 60, 100).cured_depths(20, 20)[0],
              61 * kLayerMm - 0.12 * std::log(largest + 0.75 * (sum - largest)), 1e-9);
}

TEST(DoseField, CuresDeeperBelowOverexposedLayers) {
  // Five bottom layers of 105 mJ/cm2 and 35 normal ones, of which the first two are black: the underside is at 0.1 mm.
  DoseField field(standard_resin());
  const Mask white(40, 40, [](auto, auto) { return true; });
  const Mask black(40, 40, [](auto, auto) { return false; });
  double times = 0;
  for (int k = 0; k < 40; ++k) {
    const double dose = k < 5 ? 105 : kStandardDose;
    field.add(light(k, dose), (k < 2 ? black : white).image());
    if (k >= 2) times += dose / 3.2 * std::exp(-(k + 1) * kLayerMm / 0.12);
  }
  ASSERT_GT(times, 1) << "it reaches the plate";
  EXPECT_THAT(field.cured_depths(20, 20), ElementsAre(0, DoubleNear(40 * kLayerMm, 1e-9)));
  const double higher = 1;  // the same, so far above the plate that the whole depth is there
  DoseField raised(standard_resin());
  for (int k = 2; k < 40; ++k) {
    CuredLayer layer = light(k, k < 5 ? 105 : kStandardDose);
    layer.z = layer.z + Distance::millimetres(higher);
    raised.add(layer, white.image());
  }
  EXPECT_NEAR(raised.cured_depths(20, 20)[0], higher - 0.12 * std::log(times), 1e-9);
}

TEST(DoseField, HasACrossingAtEachGapThatStaysOpen) {
  DoseField field(standard_resin(1, 0));
  const Mask white(40, 40, [](auto, auto) { return true; });
  for (const int k : {10, 20, 21, 40}) field.add(light(k, kStandardDose), white.image());
  const double deep = depth_of_layers(1);
  EXPECT_THAT(field.cured_depths(3, 3),
              ElementsAre(DoubleNear(0.55 - deep, 1e-9), DoubleNear(0.55, 1e-9), DoubleNear(1.05 - deep, 1e-9),
                          DoubleNear(1.10, 1e-9), DoubleNear(2.05 - deep, 1e-9), DoubleNear(2.05, 1e-9)));
}

TEST(DoseField, MovesTheEdgeOfAMaskAsTheBlurSays) {
  // White in columns 0 to 19: the share of light at x is the normal distribution of (20 - x) / s pixels.
  const Mask half(40, 40, [](auto x, auto) { return x < 20; });
  for (const double blur : {0.3, 0.5, 1.0}) {
    for (const double sigmas : {-1.5, -0.5, 0.0, 1.0, 2.0}) {
      const double dose = 3.2 / (std::erfc(sigmas / std::sqrt(2)) / 2);  // its critical share lies that far outside
      DoseField field(standard_resin(0, blur));
      field.add(light(50, dose), half.image());
      const double x = (20 + sigmas * blur) * kPixelMm, z = 51 * kLayerMm - 1e-7;
      EXPECT_GT(field.at(x - 0.1 * kUmInMm, 1, z), 3.2) << blur << " " << sigmas;
      EXPECT_LT(field.at(x + 0.1 * kUmInMm, 1, z), 3.2) << blur << " " << sigmas;
    }
  }
  DoseField sharp(standard_resin(0, 0));
  sharp.add(light(50, kStandardDose), half.image());
  EXPECT_NEAR(sharp.at(20 * kPixelMm - 1e-6, 1, 51 * kLayerMm - 1e-7), kStandardDose, 1e-5);
  EXPECT_EQ(sharp.at(20 * kPixelMm + 1e-6, 1, 51 * kLayerMm - 1e-7), 0);
}

TEST(DoseField, IsTheSumOverAllPixelsAndLayers) {
  std::mt19937_64 random(7);
  std::vector<Mask> masks;
  std::vector<std::vector<GreyRun>> greys(30);
  for (int k = 0; k < 30; ++k) {
    masks.emplace_back(150, 20, [&](auto x, auto) { return x > 40 && random() % 3 != 0; });
    std::uint32_t pixel = 0;
    while (k % 3 != 0 && (pixel += static_cast<std::uint32_t>(random() % 40)) < 2990) {
      const auto count = static_cast<std::uint16_t>(1 + random() % (150 - pixel % 150) % 5);
      greys[static_cast<std::size_t>(k)].push_back({pixel, count, static_cast<std::uint8_t>(1 + random() % 254)});
      pixel += count;
    }
  }
  const auto share_of = [&](std::size_t k, std::uint32_t c, std::uint32_t r) {
    for (const GreyRun& run : greys[k]) {
      if (150 * r + c >= run.pixel && 150 * r + c < run.end()) return run.level / 255.0;
    }
    return masks[k].image().at(c, r) ? 1.0 : 0.0;
  };
  for (const double blur : {0.0, 0.4, 2.0}) {
    for (const double exchange : {0.0, 0.6, 1.0}) {
      DoseField field(standard_resin(exchange, blur));
      for (int k = 0; k < 30; ++k) {
        const auto i = static_cast<std::size_t>(k);
        field.add(light(k, 5 + k % 4), masks[i].image(), greys[i]);
      }
      for (int n = 0; n < 60; ++n) {
        if (n == 40) field.drop_below(1);
        const double low = n < 40 ? 0 : 1;
        const double x = (static_cast<double>(random() % 7500) + 0.5) / 1000;
        const double y = (static_cast<double>(random() % 1000) + 0.5) / 1000;
        const double z = low + (1.5 - low) * static_cast<double>(random() % 997) / 997;
        const auto weight = [&](double u) {
          if (blur == 0) return std::abs(u) < 0.5 ? 1.0 : 0.0;
          return (std::erf((u + 0.5) / (blur * std::sqrt(2))) - std::erf((u - 0.5) / (blur * std::sqrt(2)))) / 2;
        };
        double sum = 0, largest = 0;
        for (int k = 0; k < 30; ++k) {
          const double film = (k + 1) * kLayerMm;
          if (film < z) continue;
          double share = 0;
          for (std::uint32_t r = 0; r < 20; ++r) {
            for (std::uint32_t c = 0; c < 150; ++c) {
              const double both = weight(x / kPixelMm - c - 0.5) * weight(y / kPixelMm - r - 0.5);
              if (both > 0) share += both * share_of(static_cast<std::size_t>(k), c, r);
            }
          }
          const double term = (5 + k % 4) * share * std::exp(-(film - z) / 0.12);
          sum += term;
          largest = std::max(largest, term);
        }
        EXPECT_NEAR(field.at(x, y, z), largest + (1 - exchange) * (sum - largest), 2e-3) << x << " " << y << " " << z;
      }
    }
  }
}

TEST(DoseField, CuresBelowGreyAsTheWorkingCurveSays) {
  // Cd = Dp ln(g E / Ec): one layer, white below a run of each level, and black below another.
  const Mask half(40, 40, [](auto, auto r) { return r < 20; });
  for (const std::uint8_t level : {std::uint8_t{60}, std::uint8_t{128}, std::uint8_t{200}, std::uint8_t{254}}) {
    std::vector<GreyRun> greys;
    for (std::uint32_t r = 10; r < 30; ++r) greys.push_back({40 * r + 5, 30, level});
    for (const double blur : {0.0, 0.5}) {
      DoseField field(standard_resin(0, blur));
      field.add(light(60, kStandardDose), half.image(), greys);
      const double deep = 0.12 * std::log(level / 255.0 * kStandardDose / 3.2);
      for (const std::uint32_t row : {14U, 25U}) {
        if (deep <= 0) {
          EXPECT_THAT(field.cured_depths(20, row), testing::IsEmpty()) << int{level};
        } else {
          EXPECT_THAT(field.cured_depths(20, row),
                      ElementsAre(DoubleNear(61 * kLayerMm - deep, 1e-5), DoubleNear(61 * kLayerMm, 1e-9)))
              << int{level} << " " << row;
        }
      }
      EXPECT_NEAR(field.at(1, 0.25, 61 * kLayerMm - 1e-9), kStandardDose, 1e-3) << "white beside it";
      EXPECT_NEAR(field.at(1, 1.75, 61 * kLayerMm - 1e-9), 0, 1e-3);
    }
  }
}

TEST(DoseField, IsDarkAboveTheLastFilmAndInThePlate) {
  const DoseField field = white_slab(standard_resin(), 60, 100);
  EXPECT_NEAR(field.at(1.5, 1, 5), kStandardDose, 1e-3);
  EXPECT_EQ(field.at(1, 1, 5.01), 0);
  EXPECT_EQ(field.at(1, 1, -0.01), 0);
}

TEST(DoseField, PutsALayerOfAStageThatLostStepsInItsPlace) {
  const Mask white(40, 40, [](auto, auto) { return true; });
  DoseField ordered(standard_resin()), lost(standard_resin());
  for (const int k : {3, 5, 8, 9}) ordered.add(light(k, k), white.image());
  for (const int k : {3, 8, 9, 5}) lost.add(light(k, k), white.image());
  EXPECT_EQ(ordered.cured_depths(9, 9), lost.cured_depths(9, 9));
  EXPECT_EQ(ordered.at(1, 1, 0.1), lost.at(1, 1, 0.1));
}

}  // namespace
}  // namespace plumbline
