#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <limits>
#include <set>
#include <string>
#include <vector>

#include "firmware/messages/catalogue.hpp"
#include "firmware/messages/told_text.hpp"
#include "firmware/print/status/fault.hpp"
#include "firmware/slice/issue_report.hpp"
#include "slicer/checks/issue.hpp"

namespace plumbline::firmware {
namespace {

using ::testing::HasSubstr;
using ::testing::Not;

/// All codes but kNone.
std::vector<ToldCode> all_codes() {
  std::vector<ToldCode> codes;
  for (std::size_t i = 1; i < kAllCodes; ++i) codes.push_back(static_cast<ToldCode>(i));
  return codes;
}

/// The names of the places in a text: "area_mm2", "count".
std::set<std::string> places_of(std::string_view text) {
  std::set<std::string> places;
  for (auto at = text.find('{'); at != std::string_view::npos; at = text.find('{', at + 1)) {
    places.emplace(text.substr(at + 1, text.find_first_of("?}", at) - at - 1));
  }
  return places;
}

std::string in_german(const Told& told) { return std::string(worded(told, Language::kGerman, "English").view()); }

TEST(ToldWords, EachCodeHasAGermanText) {
  std::set<std::string> facts{"name"};
  for (std::size_t i = 0; i < kAllFacts; ++i) facts.emplace(format_of(static_cast<Fact>(i)).name);
  EXPECT_EQ(facts.size(), kAllFacts + 1) << "two facts have the same name";
  std::set<std::string_view> names;
  for (const ToldCode code : all_codes()) {
    SCOPED_TRACE(to_string(code));
    EXPECT_TRUE(names.insert(to_string(code)).second) << "two codes have the same word";
    const auto words = told_words(code, Language::kGerman);
    ASSERT_TRUE(words);
    EXPECT_GT(words->sentence.size(), 4U);
    EXPECT_FALSE(words->sentence.ends_with('.')) << "a full stop comes with the remedy";
    EXPECT_TRUE(words->remedy.empty() || words->remedy.ends_with('.'));
    EXPECT_THAT(std::string(words->remedy), Not(HasSubstr("--"))) << "no flags: there are buttons";
  }
}

// At a terminal there are options, at the printer there are settings.
TEST(ToldWords, WhatToDoIsSaidInWordsOfTheOneWhoReads) {
  const Told by_scale(ToldCode::kTooHigh, {{Fact::kMostScale, 0.32}});
  EXPECT_EQ(at_terminal(by_scale, "It is too high").view(),
            "It is too high. Use --scale 0.32 or less, --fit, or rotate it.");
  EXPECT_EQ(at_printer(by_scale, "It is too high").view(),
            "It is too high. Under Settings, fit it to the plate, tilt it or print it smaller: scale 0.32 or less.");
  const Told by_size(ToldCode::kTooHigh, {{Fact::kMostMm, 61.5}}, "height");
  EXPECT_EQ(at_terminal(by_size, "It is too high").view(),
            "It is too high. Use --height 61.5mm or less, --fit, or rotate it.");
  EXPECT_EQ(at_printer(ToldCode::kLaz, "It is LAZ").view(), "It is LAZ");
  const auto error = telling(ToldCode::kNoFaces, fail(ErrorCode::kUnsupported, "a.ply: no faces;\tread it as points"));
  EXPECT_EQ(at_terminal(error.value()).view(), "a.ply: no faces. Use --as points.");
  const auto plain = fail(ErrorCode::kUnsupported, "a.ply: no faces;\tread it as points");
  EXPECT_EQ(at_terminal(plain.value()).view(), "a.ply: no faces; read it as points");
  for (const ToldCode code : all_codes()) {
    const ToldWords& english = english_remedies(code);
    EXPECT_THAT(std::string(english.remedy), Not(HasSubstr("--"))) << to_string(code);
    EXPECT_TRUE(english.terminal.empty() || english.terminal.ends_with('.')) << to_string(code);
  }
}

// It was searched for places: a bracket without an end in a file's name stopped the daemon for good.
TEST(ToldWords, AdviceOfAnErrorIsShownAsItIs) {
  for (const char* const advice :
       {"Turn it, or set island in [checks]", "Rename [a.ply", "Rename {a.ply", "Rename a{x_mm}.ply"}) {
    EXPECT_EQ(printer_remedy(PrinterCode::kIsland, advice).view(), advice);
  }
  EXPECT_EQ(printer_remedy(ToldCode::kNoFaces, "read it as points").view(),
            "Set as = \"points\" in job.toml on the stick.");
}

TEST(ToldWords, EachFaultHasAGermanMeaning) {
  for (const FaultWords& fault : fault_words(Language::kEnglish)) {
    const FaultWords& german = info(static_cast<FaultCode>(fault.number), Language::kGerman);
    EXPECT_TRUE(german.meaning.ends_with('.')) << fault.title;
    EXPECT_NE(german.meaning, fault.meaning);
  }
}

TEST(ToldWords, EachIssueIsToldWithTheFactsOfItsText) {
  PrintGrid grid;
  grid.pitch_x_mm = grid.pitch_y_mm = grid.layer_height_mm = 0.05F;
  for (std::size_t i = 0; i < kIssueKindCount; ++i) {
    const auto kind = static_cast<IssueKind>(i);
    SCOPED_TRACE(words_of(kind).key);
    StackFindings findings;
    findings.voxels = 1'000'000;
    findings.of(kind).add({.kind = kind, .layer = 7, .first_layer = 7, .last_layer = 9, .pixels = 500, .voxels = 900});
    const Told told = told_issue(kind, findings, grid);
    EXPECT_EQ(to_string(told.code), words_of(kind).key);
    const std::string sentence(told_words(told.code, Language::kGerman)->sentence);
    std::set<std::string> told_facts{"layer"};  // instead of first_layer and last_layer, if there is one
    for (std::size_t k = 0; k < told.count; ++k) told_facts.emplace(format_of(told.facts[k]).name);
    for (const std::string& place : places_of(sentence)) {
      const bool optional =
          (place == "x_mm" || place == "y_mm" || place == "from_mm") && words_of(kind).size == IssueSize::kLayers;
      EXPECT_TRUE(optional || told_facts.contains(place)) << place;
    }
    EXPECT_THAT(in_german(told), HasSubstr("Schichten 7–9. "));
  }
}

TEST(ToldWords, NumbersAreRoundedForPeopleAndOneIsNotMany) {
  const Told many(PrinterCode::kIsland, {{Fact::kCount, 3},
                                         {Fact::kAreaMm2, 113.42},
                                         {Fact::kXMm, 34.25},
                                         {Fact::kYMm, 61},
                                         {Fact::kLayer, 702},
                                         {Fact::kFromMm, 35.1}});
  EXPECT_EQ(in_german(many),
            "3 Inseln bis 113 mm² bei x 34,2, y 61,0, z 35,10 mm, Schicht 702. Stützen setzen oder drehen.");
  const Told one(PrinterCode::kIsland, {{Fact::kCount, 1}, {Fact::kAreaMm2, 1.4642}});
  EXPECT_EQ(in_german(one), "1 Insel von 1,46 mm². Stützen setzen oder drehen.");
  EXPECT_EQ(in_german({PrinterCode::kNormalsEstimated, {{Fact::kPoints, 1}}}),
            "1 Punkt ohne brauchbare Normale, sie ist aus den Nachbarn geschätzt");
  EXPECT_EQ(
      in_german({PrinterCode::kNoiseAveraged, {{Fact::kNoiseMm, 1.4321}, {Fact::kCount, 2}}}),
      "Der Scan rauscht stark, um etwa 1,4 mm: benachbarte Punkte wurden 2-mal gemittelt. Feinere Einzelheiten fehlen. "
      "Ein ruhigerer Scan zeigt mehr.");
  EXPECT_EQ(in_german({PrinterCode::kProfileUnknown, {}, "fine"}),
            "Ein Profil fine gibt es auf diesem Drucker nicht. Unter Einstellungen ein anderes wählen.");
  EXPECT_EQ(in_german({ToldCode::kForeignCad, {}, "part.step"}),
            "part.step ist ein CAD-Modell. Im CAD-Programm als STL oder 3MF exportieren.");
  EXPECT_EQ(in_german({ToldCode::kForeignPrint, {}, "part.ctb"}),
            "part.ctb ist für einen anderen Drucker geslict. Aus dem Slicer als .sl1 exportieren.");
}

TEST(ToldWords, WithoutACodeOrInEnglishTheSentenceBesideItIsShown) {
  EXPECT_EQ(in_german({}), "English");
  EXPECT_EQ(worded({ToldCode::kLaz}, Language::kEnglish, "this is LAZ").view(), "this is LAZ");
}

TEST(Told, FromAnotherProcessIsCheckedBeforeItIsUsed) {
  const Told good(PrinterCode::kIsland, {{Fact::kCount, 3}}, "name");
  EXPECT_TRUE(is_valid(good));
  EXPECT_TRUE(is_valid(Told()));
  Told told = good;
  told.code = static_cast<ToldCode>(kAllCodes);
  EXPECT_FALSE(is_valid(told));
  told = good;
  told.count = Told::kMostFacts + 1;
  EXPECT_FALSE(is_valid(told));
  told = good;
  told.facts[0] = static_cast<Fact>(kAllFacts);
  EXPECT_FALSE(is_valid(told));
  told = good;
  told.values[0] = std::numeric_limits<double>::infinity();
  EXPECT_FALSE(is_valid(told));
  told = good;
  told.text.fill('x');
  EXPECT_FALSE(is_valid(told)) << "it has no end";
}

TEST(Told, KeepsItsNameSafeAndShort) {
  const Told told(ToldCode::kForeignPrint, {}, "a\x1b[2J" + std::string(100, 'x'));
  EXPECT_TRUE(is_valid(told));
  EXPECT_THAT(std::string(told.name()), testing::StartsWith("a\\x1b[2J"));
  EXPECT_TRUE(told.name().ends_with("..."));
}

}  // namespace
}  // namespace plumbline::firmware
