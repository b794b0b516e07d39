/// Each piece of physics against its formula or brute force.

#include <gtest/gtest.h>

#include <chrono>
#include <cmath>
#include <random>
#include <vector>

#include "hal/sim/plant/cured_part.hpp"
#include "hal/sim/plant/lamp_model.hpp"
#include "hal/sim/plant/panel_model.hpp"
#include "hal/sim/plant/resin.hpp"
#include "hal/sim/plant/stage_model.hpp"
#include "hal/sim/plant/thermal_model.hpp"
#include "slicer/core/bit_spans.hpp"

namespace plumbline {
namespace {

using namespace std::chrono_literals;

TimePoint at(nanoseconds time) { return TimePoint(time); }

TEST(Resin, CuresToTheDepthOfTheWorkingCurve) {
  const Resin resin;
  const double ec = resin.critical.value();
  EXPECT_EQ(resin.cure_depth_mm(Dose(0)), 0);
  EXPECT_EQ(resin.cure_depth_mm(resin.critical), 0);
  for (const double times : {1.01, 2.0, 2.718281828459045, 10.0, 100.0}) {
    EXPECT_DOUBLE_EQ(resin.cure_depth_mm(Dose(ec * times)), resin.penetration_mm * std::log(times));
  }
  // By Beer-Lambert, the dose at the cured depth is Ec.
  const double depth = resin.cure_depth_mm(Dose(20));
  EXPECT_NEAR(20 * std::exp(-depth / resin.penetration_mm), ec, 1e-12);
}

TEST(LampModel, DoseIsTheIntegralOfTheLight) {
  std::mt19937 random(2);
  for (int run = 0; run < 50; ++run) {
    LampModel lamp(Irradiance(3), 4ms, 7ms);
    double area = 0;
    TimePoint now;
    for (int change = 0; change < 20; ++change) {
      lamp.drive(now, std::uniform_real_distribution(0.0, 1.0)(random));
      const auto time = std::chrono::microseconds(std::uniform_int_distribution(10, 20'000)(random));
      constexpr int kSteps = 500;
      for (int k = 0; k < kSteps; ++k) {
        const double here = lamp.level(now + time * k / kSteps);
        const double there = lamp.level(now + time * (k + 1) / kSteps);
        area += 0.5 * (here + there) * std::chrono::duration<double>(time).count() / kSteps;
      }
      now += time;
    }
    EXPECT_NEAR(lamp.take_dose(now).value(), 3 * area, 1e-4 * 3 * area);
    EXPECT_EQ(lamp.take_dose(now).value(), 0);
  }
}

TEST(LampModel, DoseIsIrradianceTimesTimeForEqualSlopes) {
  LampModel lamp(Irradiance(3), 1ms, 1ms);
  lamp.drive(at(10ms), 1);
  lamp.drive(at(2510ms), 0);
  EXPECT_EQ(lamp.settles_at(), at(2511ms));
  EXPECT_NEAR(lamp.take_dose(at(3s)).value(), 7.5, 1e-12);
}

TEST(StageModel, StopsAtTheEndStopAndAtTheFrame) {
  Timeline timeline{Pace()};
  const StageModel::Build build;
  StageModel stage(timeline, build);
  std::vector<LegResult> legs;
  const auto run = [&](Distance way, StageSwitch until) {
    stage.start(way, Speed(5), Acceleration(50), until, [&](const LegResult& leg) { legs.push_back(leg); });
    timeline.advance_until(timeline.now() + 100s, [&] { return !stage.moving(); });
    return legs.back();
  };
  const LegResult up = run(130_mm, StageSwitch::kPressed);
  EXPECT_EQ(up.end, LegEnd::kSwitched);
  EXPECT_EQ(up.switched, build.end_stop - build.start);
  // Braking from 5 mm/s with 50 mm/s2: v^2 / (2 a) = 0.25 mm
  EXPECT_NEAR((up.moved - up.switched).millimetres(), 0.25, 0.002);
  EXPECT_TRUE(stage.end_stop_pressed());
  const LegResult down = run(-5_mm, StageSwitch::kReleased);
  EXPECT_EQ(down.end, LegEnd::kSwitched);
  EXPECT_NEAR(stage.height().millimetres(), build.end_stop.millimetres() - 0.22, 0.05);
  const LegResult frame = run(10_mm, StageSwitch::kNone);
  EXPECT_EQ(frame.end, LegEnd::kStalled);
  EXPECT_EQ(stage.height(), build.upper_end);
}

TEST(PanelModel, ShowsTheNewMaskOnceItHasSettled) {
  Timeline timeline{Pace()};
  PanelModel::Build build;
  build.columns = 70;
  build.rows = 10;
  PanelModel panel(timeline, build);
  panel.back().set(69, 9);
  TimePoint settled;
  timeline.advance_until(at(5ms), [] { return false; });
  panel.flip(false, [&] { settled = timeline.now(); });
  timeline.advance_until(at(20ms), [] { return false; });
  EXPECT_TRUE(panel.changing());
  timeline.advance_until(at(1s), [] { return false; });
  // The flip is at the first frame after 5 ms.
  EXPECT_EQ(settled, at(build.frame * 2 + build.settling));
  EXPECT_TRUE(panel.matches_mask());
  EXPECT_EQ(panel.visible().count(), 1U);
  EXPECT_EQ(panel.back().count(), 0U);
}

TEST(PanelModel, ShowsHalfOfEachMaskWhenTorn) {
  Timeline timeline{Pace()};
  PanelModel::Build build;
  build.columns = 70;
  build.rows = 10;
  build.grey.levels = 256;
  PanelModel panel(timeline, build);
  const auto show = [&](std::uint32_t column) {
    panel.back().clear();
    panel.back_greys().clear();
    for (std::uint32_t row = 0; row < 10; ++row) panel.back().set(column, row);
    for (std::uint32_t row = 0; row < 10; ++row) panel.back_greys().add(70 * row + column - 1, 90);
    panel.flip(false, [] {});
    timeline.advance_until(timeline.now() + 1s, [] { return false; });
  };
  show(3);
  panel.torn = true;
  show(66);
  for (std::uint32_t row = 0; row < 10; ++row) {
    EXPECT_EQ(panel.visible().at(66, row), row < 5);
    EXPECT_EQ(panel.visible().at(3, row), row >= 5);
  }
  const auto greys = panel.visible_greys();
  ASSERT_EQ(greys.size(), 10U);
  for (std::uint32_t row = 0; row < 10; ++row) EXPECT_EQ(greys[row], (GreyRun{70 * row + (row < 5 ? 65 : 2), 1, 90}));
}

TEST(ThermalModel, LampApproachesItsTemperatureWithTheTimeConstant) {
  ThermalModel thermals(Celsius(20));
  thermals.set_fan(at(0s), Fan::kLamp, 1);
  thermals.set_lit(at(0s), true);
  EXPECT_NEAR(thermals.temperature(at(90s), TemperatureSite::kLamp).value(), 20 + 25 * (1 - std::exp(-1.0)), 1e-9);
  thermals.set_stalled(at(900s), Fan::kLamp, true);
  EXPECT_EQ(thermals.fan_health(Fan::kLamp), FanHealth::kStalled);
  EXPECT_NEAR(thermals.temperature(at(3000s), TemperatureSite::kLamp).value(), 80, 1e-3);
  thermals.set_lit(at(3000s), false);
  EXPECT_NEAR(thermals.temperature(at(6000s), TemperatureSite::kLamp).value(), 20, 1e-3);
}

/// Random masks. From one to the next, anywhere from none to all of the pixels change.
std::vector<std::vector<std::uint64_t>> random_masks(std::uint32_t columns, std::uint32_t rows, std::size_t count) {
  std::mt19937_64 random(3);
  std::vector<std::uint64_t> words(BitImage::words_needed(columns, rows), 0);
  std::vector<std::vector<std::uint64_t>> masks;
  for (std::size_t k = 0; k < count; ++k) {
    const auto changes = k % 5 == 0 ? 0 : k % 5 == 4 ? words.size() * 3 : random() % 40;
    for (std::size_t i = 0; i < changes; ++i) {
      const std::uint64_t change = random();
      words[static_cast<std::size_t>(random() % words.size())] ^= change & (change >> 17);
    }
    const BitImage image(words, columns, rows);
    for (std::uint32_t row = 0; row < rows; ++row) image.row(row).back() &= image.last_word_mask();
    masks.push_back(words);
  }
  return masks;
}

TEST(CuredPart, ReturnsEveryLayerAsItWasCured) {
  constexpr std::uint32_t kColumns = 1000;
  constexpr std::uint32_t kRows = 37;
  const auto masks = random_masks(kColumns, kRows, 60);
  CuredPart part(kColumns, kRows, 0.05, 0.05, {}, true);
  for (std::size_t k = 0; k < masks.size(); ++k) {
    const ZPosition z(50_um * static_cast<std::int64_t>(k + 1));
    const ConstBitImage mask(masks[k], kColumns, kRows);
    EXPECT_EQ(part.layer_at(z), k);
    // Every seventh layer takes two exposures, the first too short to cure. Every eleventh gets too little light.
    const double whole = k % 11 == 0 ? 1.0 : 8.0;
    if (k % 7 == 0) {
      part.expose(z, mask, at(1s), at(2s), Dose(8), Dose(whole / 4), Resin());
      part.expose(z, mask, at(3s), at(4s), Dose(6), Dose(whole * 3 / 4), Resin());
    } else {
      part.expose(z, mask, at(1s), at(4s), Dose(8), Dose(whole), Resin());
    }
    EXPECT_EQ(part.layer_at(z), k);
  }
  for (int reading = 0; reading < 2; ++reading) {
    std::size_t k = 0;
    part.for_each_layer([&](const CuredLayer& layer, ConstBitImage image) {
      const bool cured = k % 11 != 0;
      EXPECT_EQ(layer.exposures, k % 7 == 0 ? 2U : 1U);
      EXPECT_EQ(layer.asked.value(), 8);
      EXPECT_EQ(layer.ended, at(4s));
      EXPECT_EQ(layer.pixels, ConstBitImage(masks[k], kColumns, kRows).count());
      EXPECT_EQ(layer.depth_mm > 0, cured);
      if (cured) {
        EXPECT_TRUE(std::equal(masks[k].begin(), masks[k].end(), image.words().begin())) << k;
      } else {
        EXPECT_EQ(image.count(), 0U) << k;
      }
      ++k;
    });
    EXPECT_EQ(k, masks.size());
  }
}

TEST(CuredPart, CuresGreyPixelsWhoseShareOfTheDoseIsAboveTheCriticalOne) {
  // Ec is 2.4, so 8 mJ/cm2 cure from level 77 of 255 on.
  std::vector<std::uint64_t> words(BitImage::words_needed(100, 10));
  const BitImage mask(words, 100, 10);
  fill(mask, 3, 20, 60, true);
  const std::vector<GreyRun> greys = {{310, 10, 77}, {320, 5, 200}, {330, 5, 76}, {360, 2, 20}};
  CuredPart part(100, 10, 0.05, 0.05, {}, true);
  part.expose(ZPosition(50_um), mask, at(0s), at(1s), Dose(8), Dose(8), Resin(), greys);
  // Two exposures add up, pixel by pixel where their masks differ.
  part.expose(ZPosition(100_um), mask, at(2s), at(3s), Dose(8), Dose(4), Resin(), greys);
  part.expose(ZPosition(100_um), mask, at(4s), at(5s), Dose(4), Dose(4), Resin(), greys);
  part.expose(ZPosition(150_um), mask, at(6s), at(7s), Dose(8), Dose(4), Resin(), greys);
  part.expose(ZPosition(150_um), mask, at(8s), at(9s), Dose(4), Dose(4), Resin());
  part.expose(ZPosition(200_um), mask, at(8s), at(9s), Dose(4), Dose(8), Resin(), std::span(greys).first(1));
  std::vector<std::vector<GreyRun>> kept;
  std::vector<std::uint64_t> pixels;
  part.for_each_lit_layer([&](const CuredLayer& layer, ConstBitImage image, std::span<const GreyRun> lit) {
    kept.emplace_back(lit.begin(), lit.end());
    pixels.push_back(image.count());
    EXPECT_EQ(layer.pixels, image.count());
    if (kept.size() > 2) return;
    EXPECT_TRUE(image.at(10, 3));
    EXPECT_TRUE(image.at(20, 3));
    EXPECT_FALSE(image.at(30, 3));
    EXPECT_FALSE(image.at(60, 3));
  });
  const std::vector<GreyRun> mean = {{310, 10, 39}, {320, 5, 228}, {330, 5, 166}, {360, 2, 10}};
  EXPECT_EQ(kept, (std::vector<std::vector<GreyRun>>{greys, greys, mean, {greys[0]}}));
  EXPECT_EQ(pixels, (std::vector<std::uint64_t>{45, 45, 40, 50}));
}

TEST(CuredPart, PacksEqualLayersIntoFewBytes) {
  constexpr std::uint32_t kColumns = 1440;
  constexpr std::uint32_t kRows = 2560;
  const auto masks = random_masks(kColumns, kRows, 2);
  CuredPart part(kColumns, kRows, 0.05, 0.05, {}, true);
  for (std::int64_t k = 1; k <= 100; ++k) {
    part.expose(ZPosition(50_um * k), ConstBitImage(masks[1], kColumns, kRows), at(0s), at(1s), Dose(8), Dose(8),
                Resin());
  }
  EXPECT_LT(part.packed_bytes(), 1000U);
}

TEST(Timeline, RunsDueActionsInOrderWithoutCancelledOnes) {
  Timeline timeline{Pace()};
  std::vector<int> happened;
  timeline.at(at(20ms), [&] { happened.push_back(3); });
  timeline.at(at(10ms), [&] {
    happened.push_back(1);
    timeline.at(at(5ms), [&] { happened.push_back(2); });  // in the past, so it runs now
  });
  const auto cancelled = timeline.at(at(15ms), [&] { happened.push_back(9); });
  timeline.at(at(20ms), [&] { happened.push_back(4); });
  timeline.at(at(31ms), [&] { happened.push_back(9); });
  timeline.cancel(cancelled);
  timeline.advance_until(at(30ms), [] { return false; });
  EXPECT_EQ(happened, (std::vector<int>{1, 2, 3, 4}));
  EXPECT_EQ(timeline.now(), at(30ms));
}

TEST(Timeline, FollowsThePace) {
  Timeline timeline({.speedup = 20, .computing = 0});
  const auto start = std::chrono::steady_clock::now();
  timeline.advance_until(at(1s), [] { return false; });
  EXPECT_GE(std::chrono::steady_clock::now() - start, 45ms);
}

TEST(Timeline, ChargesTheFirmwaresComputing) {
  Timeline timeline({.speedup = 0, .computing = 100});
  timeline.enter_call();
  timeline.leave_call();
  const TimePoint before = timeline.now();
  const auto start = std::chrono::steady_clock::now();
  while (std::chrono::steady_clock::now() - start < 5ms) {
  }
  timeline.enter_call();
  timeline.leave_call();
  EXPECT_GE(timeline.now() - before, 500ms);
}

}  // namespace
}  // namespace plumbline
