#include "firmware/print/loop/resume_check.hpp"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <string>

namespace plumbline::firmware {
namespace {

using namespace plumbline::literals;
using ::testing::HasSubstr;

constexpr std::uint32_t kLayers = 20;

PrintPlan plan_of(Distance layer_height) {
  PrintPlan plan;
  plan.layers = kLayers;
  plan.layer_height = layer_height;
  return plan;
}

/// The journal's end after `cured` layers.
JournalEntry after(const PrintPlan& plan, std::uint32_t cured) {
  JournalEntry entry;
  entry.next_layer = cured;
  if (cured > 0) entry.height = height_of(plan, cured - 1);
  entry.stands = entry.height;
  return entry;
}

// With each number of cured layers the plate may have been anywhere above the last of them.
TEST(ResumeCheck, NeverConfirmsAJournalThatLacksMoreThanTheLayerAtHand) {
  for (const Distance layer : {20_um, 50_um, 100_um}) {
    const PrintPlan plan = plan_of(layer);
    for (const Distance drift : {0_um, 20_um, 80_um}) {
      for (std::uint32_t cured = 0; cured < kLayers; ++cured) {
        const ZPosition lowest = after(plan, cured).height;
        for (Distance above; above < 300_um; above = above + 1_um) {
          for (const Distance drifted : {-drift, 0_um, drift}) {
            for (std::uint32_t known = 0; known + 1 < cured; ++known) {
              ASSERT_FALSE(stage_confirms(after(plan, known), plan, lowest + above + drifted, drift))
                  << layer.micrometres() << " um layers, " << cured << " of which " << known << " are known, plate "
                  << above.micrometres() << " um above the part, drifted by " << drifted.micrometres();
            }
          }
        }
      }
    }
  }
}

TEST(ResumeCheck, ConfirmsAPlateThatStoodWhereALayerIsCured) {
  const PrintPlan plan = plan_of(50_um);
  for (const Distance drift : {0_um, 15_um}) {
    for (std::uint32_t cured = 0; cured < kLayers; ++cured) {
      const JournalEntry last = after(plan, cured);
      for (const Distance drifted : {-drift, 0_um, drift}) {
        EXPECT_TRUE(stage_confirms(last, plan, last.height + drifted, drift)) << cured;
        EXPECT_TRUE(stage_confirms(last, plan, height_of(plan, cured) + drifted, drift)) << cured;
      }
    }
  }
}

TEST(ResumeCheck, DoubtsAPlateThatWasOnItsWayOrIsLowerThanThePart) {
  const PrintPlan plan = plan_of(50_um);
  const JournalEntry last = after(plan, 10);
  EXPECT_FALSE(stage_confirms(last, plan, last.height + 3_mm, 20_um));
  EXPECT_FALSE(stage_confirms(last, plan, last.height - 100_um, 20_um));
  EXPECT_FALSE(stage_confirms(last, plan, std::nullopt, 20_um));
}

TEST(ResumeCheck, ConfirmsAPlateThatStoodWhereAPauseHasLeftIt) {
  const PrintPlan plan = plan_of(50_um);
  JournalEntry last = after(plan, 10);
  last.stands = last.height + 30_mm;
  for (const Distance drifted : {-20_um, 0_um, 20_um}) {
    EXPECT_TRUE(stage_confirms(last, plan, last.stands + drifted, 20_um));
  }
  EXPECT_FALSE(stage_confirms(last, plan, last.stands + 50_um, 20_um));
  EXPECT_FALSE(stage_confirms(last, plan, last.stands - 50_um, 20_um));
}

TEST(ResumeCheck, HasNoDoubtWhenOnlyTheRaiseIsLeft) {
  const PrintPlan plan = plan_of(50_um);
  EXPECT_TRUE(stage_confirms(after(plan, kLayers), plan, ZPosition(90_mm), 20_um));
}

TEST(ResumeCheck, SaysWhatWasFoundAndWhatToMeasure) {
  const PrintPlan plan = plan_of(50_um);
  const JournalEntry last = after(plan, 12);
  EXPECT_THAT(std::string(doubt_about(last, ZPosition(4.2_mm)).text.view()),
              HasSubstr("stood at 4.20 mm, the journal ends at 0.60 mm"));
  EXPECT_THAT(std::string(doubt_about(last, std::nullopt).text.view()), HasSubstr("not known where the plate stood"));
  EXPECT_THAT(std::string(question_about(last).text.view()), HasSubstr("0.60 mm tall (12 layers)"));
  EXPECT_THAT(std::string(question_about({}).text.view()), HasSubstr("press start if it is bare"));
}

}  // namespace
}  // namespace plumbline::firmware
