#include "firmware/slice/issue_report.hpp"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <string>
#include <vector>

namespace plumbline::firmware {
namespace {

using ::testing::ElementsAre;
using ::testing::EndsWith;
using ::testing::HasSubstr;
using ::testing::Not;
using ::testing::StartsWith;

constexpr PrintGrid kGrid{
    .columns = 1000, .rows = 2000, .layers = 500, .pitch_x_mm = 0.05F, .pitch_y_mm = 0.05F, .layer_height_mm = 0.05F};

StackFindings some_findings() {
  StackFindings findings;
  findings.layers = 500;
  findings.voxels = 80'000'000;  // 10 ml
  findings.of(IssueKind::kIsland).add({IssueKind::kIsland, 40, 40, 40, 199, 399, 120, 120});
  findings.of(IssueKind::kIsland).add({IssueKind::kIsland, 70, 70, 70, 683, 1219, 582, 582});
  findings.of(IssueKind::kFreePiece).add({IssueKind::kFreePiece, 90, 70, 109, 683, 1219, 4000, 16'000'000});
  return findings;
}

std::vector<std::string> sentences(const StackFindings& findings, const CheckPolicy& policy) {
  std::vector<std::string> all;
  for_each_issue(findings, kGrid, policy,
                 [&](IssueKind, CheckAction, std::string_view sentence) { all.emplace_back(sentence); });
  return all;
}

TEST(IssueReport, SaysSizePlaceLayersAndWhatToDo) {
  EXPECT_THAT(
      sentences(some_findings(), {}),
      ElementsAre("2 islands, the largest of 1.46 mm2 (582 px) at x 34.2, y 61.0 mm in layer 70 (3.50 mm): add "
                  "supports, or turn the object",
                  "1 piece that nothing holds, 20 % of the print: 2 ml, up to 10 mm2 in area at x 34.2, y 61.0 mm "
                  "in layers 70 to 109 (3.50 to 5.50 mm): add supports, or turn the object"));
  EXPECT_EQ(issue_counts(some_findings()).view(), "2 islands, 1 piece that nothing holds");
  EXPECT_EQ(issue_counts({}).view(), "no issues");
  StackFindings findings;
  findings.unchecked_layers = 1;
  EXPECT_EQ(issue_counts(findings).view(), "1 layer too fine to check");
}

TEST(IssueReport, SaysThatAllOfThePrintFallsInPlainDigits) {
  StackFindings findings = some_findings();
  findings.voxels = findings.of(IssueKind::kFreePiece).voxels;
  EXPECT_THAT(issue_sentence(IssueKind::kFreePiece, findings, kGrid).view(),
              testing::HasSubstr("1 piece that nothing holds, 100 % of the print: 2 ml"));
}

TEST(IssueReport, GivesSmallVolumesInCubicMillimetres) {
  StackFindings findings;
  findings.of(IssueKind::kResinTrap).add({IssueKind::kResinTrap, 190, 187, 194, 626, 675, 26, 120});
  EXPECT_THAT(std::string(issue_sentence(IssueKind::kResinTrap, findings, kGrid).view()),
              StartsWith("1 resin trap of 0.015 mm3, up to 0.065 mm2 in area"));
}

TEST(IssueReport, SaysHowMuchMoreIsLostInTheShadowOfWhatFalls) {
  StackFindings findings = some_findings();
  findings.shadowed_voxels = 4'000'000;
  const auto sentence = issue_sentence(IssueKind::kFreePiece, findings, kGrid);
  EXPECT_THAT(std::string(sentence.view()), EndsWith("(3.50 to 5.50 mm), and 0.5 ml above it then gets no light"));
  CheckPolicy policy;
  policy.of(IssueKind::kFreePiece) = CheckAction::kRefuse;
  EXPECT_THAT(std::string(judge(findings, kGrid, policy).error().advice()), HasSubstr("set free_piece in [checks]"));
}

TEST(IssueReport, SaysWithWhatForceAPieceIsPulledAndHeld) {
  StackFindings findings = some_findings();
  findings.of(IssueKind::kTear).add({IssueKind::kTear, 50, 50, 120, 683, 1219, 1600, 8'000'000, 1.234F, 0.45F});
  EXPECT_STREQ(issue_sentence(IssueKind::kTear, findings, kGrid).c_str(),
               "1 piece that the peel tears off: 1 ml, pulled with 1.23 N and held with 0.45 N at x 34.2, y 61.0 mm in "
               "layers 50 to 120 (2.50 to 6.05 mm)");
}

TEST(IssueReport, IsSilentAboutWhatIsIgnored) {
  CheckPolicy policy;
  policy.of(IssueKind::kIsland) = CheckAction::kIgnore;
  EXPECT_THAT(sentences(some_findings(), policy), ElementsAre(StartsWith("1 piece")));
  policy.of(IssueKind::kFreePiece) = CheckAction::kAsk;
  EXPECT_EQ(issue_counts(some_findings(), policy, CheckAction::kAsk).view(), "1 piece that nothing holds");
}

TEST(IssueReport, TheStrictestActionCounts) {
  CheckPolicy policy;
  EXPECT_EQ(verdict({}, policy), CheckAction::kIgnore);
  EXPECT_EQ(verdict(some_findings(), policy), CheckAction::kWarn);
  EXPECT_TRUE(judge(some_findings(), kGrid, policy));
  policy.of(IssueKind::kIsland) = CheckAction::kAsk;
  EXPECT_EQ(verdict(some_findings(), policy), CheckAction::kAsk);
  const auto asked = judge(some_findings(), kGrid, policy);
  ASSERT_FALSE(asked);
  EXPECT_EQ(asked.error().code(), ErrorCode::kBadSetting);
  EXPECT_THAT(asked.error().message(), HasSubstr("2 islands"));
  EXPECT_THAT(std::string(asked.error().advice()), StartsWith("Add supports"));
  EXPECT_THAT(std::string(asked.error().advice()), HasSubstr("--accept"));
  policy.of(IssueKind::kFreePiece) = CheckAction::kRefuse;
  EXPECT_EQ(verdict(some_findings(), policy), CheckAction::kRefuse);
  const auto refused = judge(some_findings(), kGrid, policy);
  ASSERT_FALSE(refused);
  EXPECT_THAT(refused.error().message(), HasSubstr("1 piece that nothing holds"));
  EXPECT_THAT(refused.error().message(), HasSubstr("set free_piece in [checks]"));
  EXPECT_THAT(refused.error().message(), Not(HasSubstr("also")));
  policy.actions.fill(CheckAction::kRefuse);
  EXPECT_THAT(judge(some_findings(), kGrid, policy).error().message(),
              HasSubstr("(3.50 mm); also 1 piece that nothing holds, which the profile refuses"));
  EXPECT_TRUE(judge({}, kGrid, policy)) << "nothing was found";
}

TEST(IssueReport, EveryKindHasEveryAction) {
  for (std::size_t i = 0; i < kIssueKindCount; ++i) {
    const auto kind = static_cast<IssueKind>(i);
    StackFindings findings;
    findings.voxels = 1'000'000;
    findings.of(kind).add({.kind = kind, .layer = 7, .first_layer = 7, .last_layer = 9, .pixels = 500, .voxels = 900});
    CheckPolicy policy;
    policy.actions.fill(CheckAction::kIgnore);
    CheckChoice accepted;
    accepted.accept = true;
    for (const auto action : {CheckAction::kIgnore, CheckAction::kWarn, CheckAction::kAsk, CheckAction::kRefuse}) {
      SCOPED_TRACE(std::string(words_of(kind).key) + " " +
                   std::string(kCheckActionWords[static_cast<std::size_t>(action)]));
      policy.of(kind) = action;
      EXPECT_EQ(sentences(findings, policy).size(), action == CheckAction::kIgnore ? 0U : 1U);
      EXPECT_EQ(judge(findings, kGrid, policy).has_value(), action < CheckAction::kAsk);
      EXPECT_EQ(judge(findings, kGrid, accepted.over(policy)).has_value(), action < CheckAction::kRefuse);
      policy.of(kind) = CheckAction::kIgnore;
    }
  }
}

TEST(IssueReport, CoarsePixelsHaveLimitsOfTheSameSizeInMillimetres) {
  PrintGrid coarse = kGrid;
  EXPECT_EQ(coarse_limits(coarse, {}).overhang_reach, 40U);
  EXPECT_EQ(coarse_limits(coarse, {}).suction_pixels, 100U);
  coarse.pitch_x_mm = coarse.pitch_y_mm = 0.5F;
  EXPECT_EQ(coarse_limits(coarse, {}).overhang_reach, 4U);
  EXPECT_EQ(coarse_limits(coarse, {}).suction_pixels, 1U);
  EXPECT_EQ(coarse_limits(coarse, {}).drain_pixels, 1U);
  EXPECT_EQ(coarse_limits(coarse, {}).trap_pixels, 17U);  // a hollow of one coarse pixel is noise
}

/// All kinds, as large as numbers get.
StackFindings largest_findings() {
  constexpr std::uint64_t kPixels = std::uint64_t{16384} * 16384, kVoxels = kPixels * PrintGrid::kMaxLayers;
  StackFindings findings;
  findings.voxels = findings.shadowed_voxels = kVoxels;
  findings.unchecked_layers = PrintGrid::kMaxLayers;
  for (std::size_t i = 0; i < kIssueKindCount; ++i) {
    IssueGroup& group = findings.groups[i];
    group.add(
        {static_cast<IssueKind>(i), 60000, 10000, 60000, 16383, 16383, kPixels, kVoxels / 7, 123456.7F, 123456.7F});
    group.count = 4'000'000'000U;
  }
  return findings;
}

TEST(IssueReport, NeverBreaksASentenceOff) {
  constexpr PrintGrid kLargest{.columns = 16384,
                               .rows = 16384,
                               .layers = PrintGrid::kMaxLayers,
                               .pitch_x_mm = 0.9876F,
                               .pitch_y_mm = 0.9876F,
                               .layer_height_mm = 0.9876F};
  const StackFindings findings = largest_findings();
  int seen = 0;
  for_each_issue(findings, kLargest, {}, [&](IssueKind kind, CheckAction, std::string_view sentence) {
    ++seen;
    EXPECT_LT(sentence.size(), kLongestSentence - 1) << sentence;
    EXPECT_THAT(std::string(sentence), EndsWith(std::string(words_of(kind).advice)));
    CheckPolicy policy;
    for (const CheckAction action : {CheckAction::kAsk, CheckAction::kRefuse}) {
      policy = {};
      for (std::size_t i = 0; i < kIssueKindCount; ++i) policy.of(static_cast<IssueKind>(i)) = CheckAction::kIgnore;
      policy.of(kind) = action;
      policy.of(IssueKind::kPeelJump) = policy.of(IssueKind::kTear) = action;
      const Status judged = judge(findings, kLargest, policy);
      ASSERT_FALSE(judged);
      EXPECT_THAT(std::string(judged.error().message()), testing::AnyOf(EndsWith("--accept"), EndsWith("in [checks]")));
    }
  });
  EXPECT_EQ(seen, int{kIssueKindCount});
  EXPECT_FALSE(issue_counts(findings).cut()) << issue_counts(findings).view();
}

TEST(IssueReport, CountsAndShowsOnlyWhatAPersonIsToldOf) {
  StackFindings findings = some_findings();
  findings.of(IssueKind::kIsland).minor = 1;
  findings.of(IssueKind::kFreePiece).minor = 1;
  EXPECT_EQ(issue_counts(findings).view(), "1 island");
  EXPECT_THAT(sentences(findings, {}), ElementsAre(StartsWith("1 island of 1.46 mm2")));
  CheckPolicy policy;
  policy.of(IssueKind::kFreePiece) = CheckAction::kRefuse;
  EXPECT_TRUE(judge(findings, kGrid, policy)) << "nobody is asked about what is not told";
}

}  // namespace
}  // namespace plumbline::firmware
