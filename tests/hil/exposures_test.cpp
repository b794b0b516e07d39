/// Whole prints of layers that are exposed through several masks.

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <map>

#include "slicer/core/bit_spans.hpp"
#include "tests/hil/rig.hpp"

namespace plumbline::firmware {
namespace {

using namespace std::chrono_literals;
using ::testing::Each;
using ::testing::SizeIs;
using enum PrintState;

/// The tower with a column of grey pixels of each eighth at its left.
class GreyTower final : public MaskSource {
 public:
  explicit GreyTower(MaskSource& tower) : tower_(tower) {}
  const PrintGrid& grid() const override { return tower_.grid(); }
  Expected<ConstBitImage> mask(std::uint32_t layer) override {
    const auto mask = tower_.mask(layer);
    PLUMBLINE_TRY(mask);
    words_.assign(mask->words().begin(), mask->words().end());
    const BitImage image(words_, mask->columns(), mask->rows());
    runs_.clear();
    for (std::uint32_t y = 8; y < 50; ++y) {
      for (std::uint32_t k = 1; k < 8; ++k) {
        const auto level = static_cast<std::uint8_t>(std::lround(255 * k / 8.0));
        runs_.push_back({y * kRigColumns + layer + k, 1, level});
      }
    }
    set_bits(runs_, image);
    return ConstBitImage(image);
  }
  std::span<const GreyRun> greys() const override { return runs_; }

 private:
  MaskSource& tower_;
  std::vector<std::uint64_t> words_;
  std::vector<GreyRun> runs_;
};

/// A panel of black and white that shows each layer in four exposures; the outline of bottom layers in a fifth.
class ExposuresRig : public Rig {
 public:
  explicit ExposuresRig(const std::vector<std::string>& faults = {}, nanoseconds per_mask = {})
      : Rig(with(faults, per_mask)) {
    MachineFile machine = rig_machine();
    machine.panel.grey = {.exposures = 3};
    profile.elefant_foot_compensation = 0.3;
    profile.grey = Grey::kVertical;
    plan = plan_print(profile, machine, 0.05, kLayers).value();
    wrap = [this](MaskSource& tower) -> MaskSource& { return source_.emplace(tower); };
  }

 private:
  static PlantSettings with(const std::vector<std::string>& faults, nanoseconds per_mask) {
    PlantSettings settings = rig_plant();
    for (const auto& fault : faults) settings.faults.push_back(parse_fault(fault).value());
    settings.compute_per_mask = per_mask;
    return settings;
  }
  std::optional<GreyTower> source_;
};

/// What each pixel of a part got of its layer's light, 0 to 255, by layer.
std::vector<std::vector<int>> light_of(const Rig& rig) {
  std::vector<std::vector<int>> all;
  rig.plant.part().for_each_lit_layer([&](const CuredLayer&, ConstBitImage bits, std::span<const GreyRun> greys) {
    auto& light = all.emplace_back();
    for (std::uint32_t pixel = 0; pixel < kRigColumns * kRigRows; ++pixel) {
      light.push_back(bits.at(pixel % kRigColumns, pixel / kRigColumns) ? 255 : 0);
    }
    for (const GreyRun& run : greys) {
      for (std::uint32_t pixel = run.pixel; pixel < run.end(); ++pixel) light[pixel] = run.level;
    }
  });
  return all;
}

/// The largest difference between two.
int difference(const std::vector<std::vector<int>>& a, const std::vector<std::vector<int>>& b) {
  EXPECT_EQ(a.size(), b.size());
  int most = 0;
  for (std::size_t layer = 0; layer < std::min(a.size(), b.size()); ++layer) {
    for (std::size_t i = 0; i < a[layer].size(); ++i) most = std::max(most, std::abs(a[layer][i] - b[layer][i]));
  }
  return most;
}

std::vector<double> doses_of(const Rig& rig) {
  std::vector<double> shares;
  for (const CuredLayer& layer : rig.plant.part().layers()) {
    const auto k = static_cast<std::uint32_t>(shares.size());
    shares.push_back(layer.dose / dose_of(Irradiance(3.5), exposure_of(rig.plan, k)));
  }
  return shares;
}

TEST(Exposures, GiveEachPixelItsShareOfTheLight) {
  ExposuresRig rig;
  const auto& report = rig.run();
  rig.plant.conclude(JobEnd::kFinished);
  ASSERT_EQ(report.state, kFinished) << report.fault_message.c_str();
  EXPECT_EQ(rig.objections(), "");
  EXPECT_EQ(report.late_masks, 0U);
  EXPECT_THAT(doses_of(rig), Each(testing::DoubleNear(1, 2e-3)));
  const auto light = light_of(rig);
  const auto at = [&](std::uint32_t layer, std::uint32_t x) { return light[layer][30 * kRigColumns + x]; };
  for (std::uint32_t k = 1; k < 8; ++k) {
    EXPECT_NEAR(at(30, 30 + k), 255 * k / 8.0, 1) << "a normal layer";
    EXPECT_NEAR(at(0, k), 255 * k / 16.0, 1) << "of 5 s, of which the outline gets half";
  }
  EXPECT_EQ(at(30, 45), 255);
  EXPECT_EQ(at(0, 30), 255);
  EXPECT_EQ(at(0, 49), 128) << "the outline";
  EXPECT_THAT(report.exposures, SizeIs(4 * Rig::kLayers + 4)) << "two bottom and two faded layers have a foot";
  std::map<std::uint32_t, nanoseconds> asked;
  for (const auto& line : report.exposures) asked[line.layer] += line.asked;
  for (const auto& [layer, time] : asked) EXPECT_EQ(time, exposure_of(rig.plan, layer));
  EXPECT_LT(std::chrono::abs(report.elapsed - report.estimated), 80s);
}

TEST(Exposures, ThatAreInterruptedGoOnWhereTheyStopped) {
  ExposuresRig whole;
  whole.run();
  const auto light = light_of(whole);
  // In each of the exposures and between them.
  for (const char* when : {"0s", "0.2s", "0.32s", "0.34s", "0.5s", "0.69s", "1s", "1.37s", "1.4s", "2.55s"}) {
    SCOPED_TRACE(when);
    ExposuresRig rig({std::string("cover.opens@layer=20+") + when + ",for=30s"});
    EXPECT_EQ(rig.run().state, kFinished);
    rig.plant.conclude(JobEnd::kFinished);
    EXPECT_EQ(rig.objections(), "");
    EXPECT_LE(difference(light_of(rig), light), 2) << "of 255: the lamp needs 1 ms";
    EXPECT_THAT(doses_of(rig), Each(testing::DoubleNear(1, 3e-3)));
  }
}

TEST(Exposures, ThatAnEndedProgramLeftGoOnWhereTheyStopped) {
  ExposuresRig whole;
  whole.run();
  const auto light = light_of(whole);
  for (const auto after : {1ms, 30ms, 200ms, 360ms, 800ms, 1050ms, 2000ms}) {
    SCOPED_TRACE(after.count());
    ExposuresRig rig;
    // When the first exposure of layer 20 is over, which takes 0.3125 s.
    const std::function<void()> look = [&] {
      const auto lights = rig.plant.lights();
      if (!lights.empty() && lights.back().layer == 20) {
        rig.plant.timeline().at(rig.plant.now() + after, [&] { rig.plant.press(EventKind::kShutdownRequested); });
      } else {
        rig.plant.timeline().at(rig.plant.now() + 1ms, look);
      }
    };
    rig.plant.timeline().at(rig.plant.now(), look);
    EXPECT_EQ(rig.run().state, kSuspended);
    EXPECT_EQ(rig.run().state, kFinished);
    rig.plant.conclude(JobEnd::kFinished);
    EXPECT_EQ(rig.objections(), "");
    EXPECT_LE(difference(light_of(rig), light), 2);
    EXPECT_THAT(doses_of(rig), Each(testing::DoubleNear(1, 3e-3)));
  }
}

TEST(Exposures, ThatWaitForTheirMaskAreWhole) {
  ExposuresRig rig({}, 400ms);
  const auto& report = rig.run();
  rig.plant.conclude(JobEnd::kFinished);
  EXPECT_EQ(report.state, kFinished);
  EXPECT_EQ(rig.objections(), "");
  EXPECT_EQ(report.late_masks, 2 * Rig::kLayers) << "under the two exposures of 0.31 s";
  EXPECT_THAT(doses_of(rig), Each(testing::DoubleNear(1, 2e-3)));
}

}  // namespace
}  // namespace plumbline::firmware
