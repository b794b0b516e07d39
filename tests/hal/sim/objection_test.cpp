/// Provokes each objection once, with a faulty firmware or back end.

#include "hal/sim/plant/objection.hpp"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <chrono>
#include <set>

#include "hal/sim/sim_machine.hpp"
#include "tests/hal/sim/sim_fixture.hpp"
#include "tests/hal/small_print.hpp"

namespace plumbline {
namespace {

using namespace std::chrono_literals;
using testing::ElementsAre;
using testing::IsEmpty;

/// Prints two correct layers, then leaves the wires to the test.
class Objections : public testing::Test {
 protected:
  void SetUp() override {
    {
      SimMachine machine(plant_);
      ASSERT_TRUE(print_layers(machine.machine(), {.layers = 2}));
    }
    ASSERT_THAT(texts_of(plant_.objections()), IsEmpty());
  }

  void go_to(Distance height) {
    plant_.start_leg(height - plant_.stage().height(), Speed(4), StageSwitch::kNone, [](const LegResult&) {});
    plant_.timeline().advance_until(plant_.now() + 100s, [this] { return !plant_.stage().moving(); });
  }
  void show(bool black = false) {
    for (auto& word : plant_.panel().back().words()) word = 1;
    plant_.panel().flip(black, [] {});
    plant_.wait(1s);
  }
  void light(nanoseconds time) {
    plant_.lamp_line(true);
    plant_.wait(time);
    plant_.lamp_line(false);
    plant_.wait(10ms);
  }
  auto objections() { return kinds_of(plant_.objections()); }

  Plant plant_{small_printer()};
};

TEST_F(Objections, NoneToACorrectBackEnd) {
  go_to(150_um);
  show();
  plant_.expect_light(2s);
  light(2s);
  show(true);
  go_to(5_mm);
  plant_.conclude(JobEnd::kFinished);
  EXPECT_THAT(texts_of(plant_.objections()), IsEmpty());
  EXPECT_EQ(plant_.part().layers().size(), 3U);
}

TEST_F(Objections, ToAMaskThatChangesUnderLight) {
  go_to(150_um);
  show();
  plant_.lamp_line(true);
  show();
  plant_.lamp_line(false);
  EXPECT_THAT(objections(), ElementsAre(ObjectionKind::kMaskChangedUnderLight));
}

TEST_F(Objections, ToBlankingUnderLight) {
  go_to(150_um);
  show();
  plant_.lamp_line(true);
  show(true);
  plant_.lamp_line(false);
  EXPECT_THAT(objections(), ElementsAre(ObjectionKind::kMaskChangedUnderLight));
}

TEST_F(Objections, ToLightBeforeTheEndOfTheScanOut) {
  go_to(150_um);
  plant_.panel().flip(false, [] {});
  plant_.wait(30ms);
  light(1s);
  EXPECT_THAT(objections(), ElementsAre(ObjectionKind::kMaskTornUnderLight));
}

TEST_F(Objections, ToLightThroughATornMask) {
  go_to(150_um);
  plant_.panel().torn = true;
  show();
  light(1s);
  EXPECT_THAT(objections(), ElementsAre(ObjectionKind::kMaskTornUnderLight));
}

TEST_F(Objections, ToMotionUnderLight) {
  go_to(150_um);
  show();
  plant_.lamp_line(true);
  go_to(200_um);
  plant_.lamp_line(false);
  EXPECT_THAT(objections(), ElementsAre(ObjectionKind::kMotionUnderLight));
}

TEST_F(Objections, ToLightWhileTheStageMoves) {
  show();
  plant_.start_leg(-1_mm, Speed(1), StageSwitch::kNone, [](const LegResult&) {});
  plant_.wait(100ms);
  light(10ms);
  EXPECT_THAT(objections(), ElementsAre(ObjectionKind::kMotionUnderLight));
}

TEST_F(Objections, ToLightThatOutlastsTheOpeningOfTheCover) {
  go_to(150_um);
  show();
  plant_.lamp_line(true);
  plant_.wait(1s);
  plant_.open_cover();
  plant_.wait(9ms);
  EXPECT_THAT(objections(), IsEmpty());
  plant_.wait(2ms);
  plant_.lamp_line(false);
  EXPECT_THAT(objections(), ElementsAre(ObjectionKind::kLightWithCoverOpen));
}

TEST_F(Objections, ToLightWithTheCoverOpen) {
  go_to(150_um);
  show();
  plant_.open_cover();
  plant_.wait(1s);
  light(1ms);
  EXPECT_THAT(objections(), ElementsAre(ObjectionKind::kLightWithCoverOpen));
}

TEST_F(Objections, ToLightThroughABlankPanel) {
  go_to(150_um);
  light(1s);
  EXPECT_THAT(objections(), ElementsAre(ObjectionKind::kExposureWithoutMask));
}

TEST_F(Objections, ToThePlateInTheFilm) {
  Plant empty(small_printer());
  empty.start_leg(-1_mm - empty.stage().height(), Speed(4), StageSwitch::kNone, [](const LegResult&) {});
  empty.wait(100s);
  EXPECT_THAT(kinds_of(empty.objections()), ElementsAre(ObjectionKind::kTravelPastEnd));
}

TEST_F(Objections, ToThePartInTheFilm) {
  go_to(70_um);  // two layers of 50 um hang below the plate
  EXPECT_THAT(objections(), ElementsAre(ObjectionKind::kTravelPastEnd));
}

TEST_F(Objections, ToTheCarriageInTheFrame) {
  go_to(200_mm);
  EXPECT_THAT(objections(), ElementsAre(ObjectionKind::kTravelPastEnd));
}

TEST_F(Objections, ToASkippedLift) {
  go_to(150_um);
  show();
  light(2s);
  go_to(200_um);
  light(2s);
  EXPECT_THAT(objections(), ElementsAre(ObjectionKind::kLiftSkipped));
}

TEST_F(Objections, ToALiftTooShortForTheFilm) {
  go_to(150_um);
  show();
  light(2s);
  go_to(1100_um);  // the film stretches 1 mm
  go_to(200_um);
  light(2s);
  EXPECT_THAT(objections(), ElementsAre(ObjectionKind::kLiftSkipped));
}

TEST_F(Objections, ToALiftTooFastForTheArea) {
  go_to(150_um);
  show();
  light(2s);
  go_to(1200_um);  // 100 um beyond the film's stretch takes less than the 0.2 s that peeling needs
  go_to(200_um);
  light(2s);
  EXPECT_THAT(objections(), ElementsAre(ObjectionKind::kLiftSkipped));
}

TEST_F(Objections, ToADoseThatIsOffByMoreThanOnePercent) {
  for (const auto& [layer, lit] : {std::pair{3, 1981ms}, {4, 1979ms}, {5, 2019ms}, {6, 2021ms}}) {
    go_to(50_um * layer);
    show();
    plant_.expect_light(2s);
    light(lit);
    show(true);
    go_to(5_mm);
  }
  plant_.conclude(JobEnd::kFinished);
  EXPECT_THAT(objections(), ElementsAre(ObjectionKind::kDoseOff, ObjectionKind::kDoseOff));
  EXPECT_EQ(plant_.objections()[0].layer, 3U);
  EXPECT_EQ(plant_.objections()[1].layer, 5U);
}

TEST_F(Objections, NoneToADoseInTwoParts) {
  go_to(150_um);
  show();
  plant_.expect_light(2s);
  light(700ms);
  go_to(40_mm);
  plant_.wait(600s);
  go_to(150_um);
  plant_.expect_light(1300ms);
  light(1300ms);
  plant_.conclude(JobEnd::kFinished);
  EXPECT_THAT(texts_of(plant_.objections()), IsEmpty());
  EXPECT_EQ(plant_.part().layers().back().exposures, 2U);
}

TEST_F(Objections, ToTheLastLayersDoseOnlyIfTheJobFinished) {
  go_to(150_um);
  show();
  plant_.expect_light(2s);
  light(700ms);
  plant_.conclude(JobEnd::kAbandoned);
  EXPECT_THAT(texts_of(plant_.objections()), IsEmpty());
}

TEST_F(Objections, ToALayerThatDoesNotReachTheLayerAbove) {
  // Cd = 0.11 ln(6 / 2.4) = 0.1008 mm
  go_to(200_um);  // 100 um below the last one
  show();
  plant_.expect_light(2s);
  light(2s);
  show(true);
  go_to(5_mm);
  go_to(302.5_um);  // 102.5 um below that
  show();
  plant_.expect_light(2s);
  light(2s);
  plant_.conclude(JobEnd::kFinished);
  EXPECT_THAT(objections(), ElementsAre(ObjectionKind::kNotBonded));
  EXPECT_EQ(plant_.objections()[0].layer, 3U);
}

TEST_F(Objections, ReportTimeLayerAndHeight) {
  go_to(150_um);
  light(1s);
  const Objection& objection = plant_.objections()[0];
  EXPECT_EQ(objection.z, ZPosition(150_um));
  EXPECT_EQ(objection.layer, 2U);
  EXPECT_THAT(to_string(objection), testing::HasSubstr(" s, layer 2, 0.150 mm: exposure without a mask"));
}

TEST_F(Objections, HaveDifferentNames) {
  std::set<std::string_view> names;
  for (std::size_t i = 0; i < kObjectionKindCount; ++i) names.insert(to_string(static_cast<ObjectionKind>(i)));
  EXPECT_EQ(names.size(), kObjectionKindCount);
  EXPECT_EQ(names.count("unknown objection"), 0U);
}

}  // namespace
}  // namespace plumbline
