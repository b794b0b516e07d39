/// Whole prints of a bridge, with an uneven lamp and with strips of different exposures: how deep and how wide its underside and its sides
/// are cured.

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "hal/sim/part/dose_field.hpp"
#include "slicer/core/bit_spans.hpp"
#include "tests/hil/rig.hpp"

namespace plumbline::firmware {
namespace {

using namespace std::chrono_literals;
using ::testing::ElementsAre;
using ::testing::IsEmpty;

constexpr std::uint32_t kLeft = 5, kRight = 125, kTop = 12, kBottom = 52,
                        kDeck = 20;  // of the deck, and its first layer
constexpr double kDp = 0.12;

/// Two piers, and from layer kDeck on a deck over all of them.
class Bridge final : public MaskSource {
 public:
  explicit Bridge(const PrintGrid& grid) : grid_(grid), words_(BitImage::words_needed(grid.columns, grid.rows)) {}
  const PrintGrid& grid() const override { return grid_; }
  Expected<ConstBitImage> mask(std::uint32_t layer) override {
    const BitImage image(words_, grid_.columns, grid_.rows);
    image.clear();
    for (std::uint32_t y = kTop; y < kBottom; ++y) {
      fill(image, y, kLeft, layer < kDeck ? kLeft + 4 : kRight, true);
      fill(image, y, kRight - 4, kRight, true);
    }
    return ConstBitImage(image);
  }

 private:
  PrintGrid grid_;
  std::vector<std::uint64_t> words_;
};

/// Brighter by a fifth at the right edge than at the left one.
double uneven(double x_mm, double /*y_mm*/) {
  const double across = x_mm / (kRigColumns * kRigPitchMm);
  return 1 + 0.2 * across * across;
}

struct BridgeRig : Rig {
  explicit BridgeRig(const PlantSettings& settings = with({})) : Rig(settings) {
    wrap = [this](MaskSource& tower) -> MaskSource& { return source_.emplace(tower.grid()); };
  }
  static PlantSettings with(const std::vector<std::string>& faults) {
    PlantSettings settings = rig_plant();
    for (const auto& fault : faults) settings.faults.push_back(parse_fault(fault).value());
    return settings;
  }
  /// What the part got; lamp: null, even.
  DoseField field(std::function<double(double, double)> lamp = nullptr) const {
    return {{.resin = plant.settings().resin,
             .pitch_x_mm = kRigPitchMm,
             .pitch_y_mm = kRigPitchMm,
             .lamp = std::move(lamp)},
            plant.part()};
  }

 private:
  std::optional<Bridge> source_;
};

/// mm from the plate of the deck's underside at a column.
double underside(const DoseField& field, std::uint32_t column) { return field.cured_depths(column, 30).front(); }

/// mm from the deck's middle to its side, along y.
double half_width(const DoseField& field, std::uint32_t column) {
  const double critical = field.model().resin.critical.value(), x = (column + 0.5) * kRigPitchMm;
  double in = 32 * kRigPitchMm, out = 60 * kRigPitchMm;
  while (out - in > 1e-6) {
    const double y = (in + out) / 2;
    (field.at(x, y, 1.5) >= critical ? in : out) = y;
  }
  return in - 32 * kRigPitchMm;
}

template <class Measure>
double spread_um(const DoseField& field, Measure measure) {
  double least = 1e9, most = -1e9;
  for (std::uint32_t column = kLeft + 10; column < kRight - 10; ++column) {
    least = std::min(least, measure(field, column));
    most = std::max(most, measure(field, column));
  }
  return 1000 * (most - least);
}

TEST(LampMapOfAPrint, TakesTheSpreadOutOfUndersidesAndWidths) {
  std::array<double, 2> deep{}, wide{};
  for (const bool mapped : {false, true}) {
    PlantSettings settings = rig_plant();
    settings.panel.grey = {.levels = 256};
    if (mapped) {
      LampMap& map = settings.panel.lamp;
      map = {.columns = 8, .rows = 4};
      for (std::uint32_t i = 0; i < 32; ++i)
        map.light[i] = 3.5 * uneven((i % 8 + 0.5) / 8 * kRigColumns * kRigPitchMm, 0);
    }
    BridgeRig rig(settings);
    const auto report = rig.run();
    rig.plant.conclude(JobEnd::kFinished);
    ASSERT_EQ(report.state, PrintState::kFinished) << report.fault_message.c_str();
    EXPECT_EQ(rig.objections(), "");
    EXPECT_EQ(report.exposures.size(), std::size_t{Rig::kLayers});
    const DoseField field = rig.field(uneven);
    deep[mapped ? 1 : 0] = spread_um(field, underside);
    wide[mapped ? 1 : 0] = spread_um(field, half_width);
  }
  EXPECT_NEAR(deep[0], 1000 * kDp * std::log(uneven(11.45, 0) / uneven(1.55, 0)), 0.1) << "Jacobs";
  EXPECT_LT(deep[1], 0.6) << "of 17 um";
  EXPECT_GT(wide[0], 4);
  EXPECT_LT(wide[1], 0.2);
}

/// Strips of 30 columns with four exposures.
struct StripsRig : BridgeRig {
  explicit StripsRig(const std::vector<std::string>& faults = {}) : BridgeRig(with(faults)) {
    profile.exposure_test = {.strips = 4, .seconds = {1.6, 2, 2.4, 2.8}};
    profile.exposure_time = 2.8;
    plan = plan_print(profile, rig_machine(), 0.05, kLayers).value();
    plan.test.begin = kLeft;
    plan.test.end = kRight;
  }
};
constexpr std::array<double, 4> kTimes = {1.6, 2, 2.4, 2.8};
constexpr std::uint32_t middle_of(std::uint32_t strip) { return kLeft + 30 * strip + 15; }

TEST(ExposureTestOfAPrint, CuresEachStripByItsTime) {
  StripsRig rig;
  const auto report = rig.run();
  rig.plant.conclude(JobEnd::kFinished);
  ASSERT_EQ(report.state, PrintState::kFinished) << report.fault_message.c_str();
  EXPECT_EQ(rig.objections(), "");
  std::vector<nanoseconds> bottom, pier, deck;
  for (const auto& line : report.exposures) {
    if (line.layer == 0) bottom.push_back(line.asked);
    if (line.layer == 10) pier.push_back(line.asked);
    if (line.layer == 30) deck.push_back(line.asked);
    EXPECT_LE(line.exposure, 3U);
  }
  EXPECT_THAT(bottom, ElementsAre(5s));
  EXPECT_THAT(pier, ElementsAre(1600ms, 1200ms)) << "strips 2 and 3 have no pixels";
  EXPECT_THAT(deck, ElementsAre(1600ms, 400ms, 400ms, 400ms));
  const DoseField field = rig.field();
  for (std::uint32_t c = 1; c < 4; ++c) {
    const double deeper = underside(field, middle_of(0)) - underside(field, middle_of(c));
    EXPECT_NEAR(1000 * deeper, 1000 * kDp * std::log(kTimes[c] / kTimes[0]), 0.5)
        << "um, strip " << c + 1 << ": Jacobs";
    EXPECT_GT(half_width(field, middle_of(c)), half_width(field, middle_of(c - 1)) + 0.002);
  }
  EXPECT_LT(std::chrono::abs(report.elapsed - report.estimated), 80s);
}

TEST(ExposureTestOfAPrint, GoesOnWhereItStopped) {
  StripsRig whole;
  whole.run();
  const DoseField expected = whole.field();
  for (const char* when : {"0s", "1s", "1.59s", "1.62s", "1.7s", "2.1s", "2.75s"}) {
    SCOPED_TRACE(when);
    for (const std::string fault : {"cover.opens@layer=20+", "system.shutdown@layer=20+"}) {
      StripsRig rig({fault + when + (fault.starts_with("cover") ? ",for=30s" : "")});
      const bool ends = fault.starts_with("system");
      EXPECT_TRUE(!ends || rig.run().state == PrintState::kSuspended);
      EXPECT_EQ(rig.run().state, PrintState::kFinished);
      rig.plant.conclude(JobEnd::kFinished);
      EXPECT_EQ(rig.objections(), "");
      const DoseField field = rig.field();
      for (std::uint32_t c = 0; c < 4; ++c) {
        EXPECT_NEAR(underside(field, middle_of(c)), underside(expected, middle_of(c)), 0.0005) << c;
      }
    }
  }
}

}  // namespace
}  // namespace plumbline::firmware
