#include "firmware/print/job/contract.hpp"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <string>
#include <vector>

#include "firmware/messages/printer_code.hpp"
#include "firmware/settings/print_profile.hpp"
#include "firmware/settings/print_values.hpp"
#include "tests/firmware/support/job_fixture.hpp"

namespace plumbline::firmware {
namespace {

using ::testing::ElementsAre;
using ::testing::HasSubstr;
using ::testing::IsEmpty;
using ::testing::Not;

PrintProfile standard_profile() {
  return read_print_profile(std::string(PLUMBLINE_SOURCE_DIR) + "/board/profiles/standard.toml").value();
}

MachineFile sim2k() {
  return *read_board_file(std::string(PLUMBLINE_SOURCE_DIR) + "/board/sim2k.toml").value().machine;
}

ContractSubject an_archive() {
  return {.grid = {.columns = 100,
                   .rows = 100,
                   .layers = 40,
                   .pitch_x_mm = 0.05F,
                   .pitch_y_mm = 0.05F,
                   .layer_height_mm = 0.05F},
          .columns = 20,
          .rows = 10,
          .cured_pixels = 8000,
          .first_layer_pixels = 200,
          .is_archive = true};
}

std::vector<std::string> doubts_in(const Contract& contract) {
  std::vector<std::string> all;
  for_each_doubt(contract, "part.zip", [&all](const Told& told, std::string_view text) {
    EXPECT_FALSE(told.empty());
    all.emplace_back(text);
  });
  return all;
}

std::string lines_of(const Contract& contract) {
  std::string all;
  for_each_contract_line(contract, [&all](std::string_view line) { all.append(line).append("\n"); });
  return all;
}

TEST(Contract, ShowsTheValuesThatThePlanCarriesOut) {
  PrintProfile profile = standard_profile();
  // A different value for each field, in the middle of its range, so that no two can be taken for each other.
  double share = 0.3;
  for (const PrintField& field : kPrintFields) {
    share += 0.01;
    const double value = field.low + share * (std::min(field.high, 40.0) - field.low);
    set_value(profile, field, field.is_whole() ? std::round(value) : value, ValueSource::kPerson);
  }
  profile.layer_height = double{0.05F};
  MachineFile machine = sim2k();
  machine.max_exposure_s = 300;
  machine.max_light_per_minute_s = 60;
  const auto contract = make_contract(profile, machine, an_archive());
  ASSERT_TRUE(contract) << contract.error().message();
  for (const PrintField& field : kPrintFields) {
    EXPECT_NEAR(value_of(contract->plan, field.key), value_of(profile, field), 1e-6) << field.name;
  }
}

TEST(Contract, MovesTheStageByWholeLayersAndTellsTheSizeThatIsLeftOfThem) {
  ContractSubject scan = an_archive();
  scan.is_archive = false;
  const Contract plain = make_contract(standard_profile(), sim2k(), scan).value();
  scan.sizes = {{1.02, 1.01, 1.05}, -0.02};
  scan.grid.pitch_x_mm /= 1.02F;
  scan.grid.pitch_y_mm /= 1.01F;
  scan.grid.layer_height_mm /= 1.05F;
  const Contract corrected = make_contract(standard_profile(), sim2k(), scan).value();
  EXPECT_EQ(corrected.plan.layer_height, plain.plan.layer_height);
  EXPECT_NEAR(corrected.width_mm, plain.width_mm / 1.02, 1e-6);
  EXPECT_NEAR(corrected.depth_mm, plain.depth_mm / 1.01, 1e-6);
  EXPECT_NEAR(corrected.height_mm, plain.height_mm / 1.05, 1e-6);
  EXPECT_NEAR(corrected.resin_ml, plain.resin_ml, 1e-7);
  std::string said, before;
  for_each_contract_line(corrected, [&](std::string_view line) { said.append(line) += "\n"; });
  for_each_contract_line(plain, [&](std::string_view line) { before.append(line) += "\n"; });
  EXPECT_THAT(said,
              HasSubstr("\ncorrected  masks 1.02, 1.01, 1.05 times as large in x, y, z; outlines moved by -0.02 mm\n"));
  EXPECT_THAT(before, Not(HasSubstr("corrected")));
}

TEST(Contract, IsDoubtfulWhereAnArchiveIsSilentAboutHeightOrExposure) {
  const auto silent = make_contract(standard_profile(), sim2k(), an_archive());
  ASSERT_TRUE(silent);
  EXPECT_THAT(doubts_in(*silent),
              ElementsAre("part.zip does not say how high its layers are: 0.05 mm is the profile's",
                          "part.zip does not say how long its layers are exposed: 2.5 s and 30 s for the first are the "
                          "profile's"));
  PrintProfile said = standard_profile();
  PrintValues values;
  values[index_of(PrintKey::kLayerHeight)] = 0.05;
  values[index_of(PrintKey::kExposureTime)] = 3;
  set_values(said, values, ValueSource::kArchive);
  EXPECT_THAT(
      doubts_in(*make_contract(said, sim2k(), an_archive())),
      ElementsAre("part.zip does not say how long its layers are exposed: 30 s for the first is the profile's"));
  set_value(said, kPrintFields[index_of(PrintKey::kInitialExposureTime)], 20, ValueSource::kPerson);
  EXPECT_THAT(doubts_in(*make_contract(said, sim2k(), an_archive())), IsEmpty());
}

TEST(Contract, AsksAboutGreyThatMatters) {
  PrintProfile said = standard_profile();
  for (const PrintKey key : {PrintKey::kLayerHeight, PrintKey::kExposureTime, PrintKey::kInitialExposureTime}) {
    said.sources[index_of(key)] = ValueSource::kArchive;
  }
  MachineFile black_or_white = sim2k();
  black_or_white.panel.grey = {};
  ContractSubject grey = an_archive();
  grey.grey = 0.009;
  EXPECT_THAT(doubts_in(*make_contract(said, black_or_white, grey)), IsEmpty());
  grey.grey = 0.52;
  grey.grey_lost = 0.5;
  EXPECT_THAT(doubts_in(*make_contract(said, sim2k(), grey)), IsEmpty()) << "its panel shows grey";
  EXPECT_THAT(lines_of(*make_contract(said, sim2k(), grey)), HasSubstr(", 52 % of its area grey\n"));
  EXPECT_THAT(lines_of(*make_contract(said, black_or_white, grey)),
              HasSubstr(", 52 % of its area grey: the panel shows black or white, so 50 % of the area vanishes\n"));
  EXPECT_THAT(doubts_in(*make_contract(said, black_or_white, grey)),
              ElementsAre("52 % of the area of part.zip is grey: 50 % vanishes, the rest cures as white"));
}

TEST(Contract, SaysWhatGreyByExposuresCosts) {
  PrintProfile said = standard_profile();
  for (const PrintKey key : {PrintKey::kLayerHeight, PrintKey::kExposureTime, PrintKey::kInitialExposureTime}) {
    said.sources[index_of(key)] = ValueSource::kArchive;
  }
  MachineFile machine = sim2k();
  machine.panel.grey = {.exposures = 3};
  ContractSubject archive = an_archive();
  const auto plain = make_contract(said, machine, archive);
  EXPECT_EQ(plain->plan.grey_exposures, 0U);
  EXPECT_THAT(lines_of(*plain), Not(HasSubstr("grey")));
  archive.grey = 0.5;
  archive.grey_lost = 0.3;
  const auto grey = make_contract(said, machine, archive);
  EXPECT_THAT(doubts_in(*grey), IsEmpty());
  EXPECT_THAT(lines_of(*grey),
              HasSubstr("\ngrey       by up to 4 exposures of a layer instead of one: 0.11 s more for a "
                        "layer with grey pixels\n"));
  EXPECT_EQ(grey->time - plain->time, std::chrono::seconds(std::lround(grey->plan.layers * 3 * 0.0366667)));
  said.exposure_time = 0.3;
  EXPECT_THAT(
      lines_of(*make_contract(said, machine, archive)),
      HasSubstr("\ngrey       by up to 2 exposures of a layer instead of one: 0.04 s more for a layer with grey "
                "pixels. With 4, one would be shorter than 0.1 s\n"));
  said.exposure_time = 0.15;
  const auto short_ones = make_contract(said, machine, archive);
  EXPECT_THAT(lines_of(*short_ones), HasSubstr("\ngrey       becomes black or white: half an exposure would be"));
  EXPECT_TRUE(short_ones->doubts_about(Doubt::kGrey));
}

TEST(Contract, HasTheStripsOfAnExposureTest) {
  PrintProfile profile = standard_profile();
  profile.exposure_test = {.strips = 4, .seconds = {2, 2.5, 3, 3.5}};
  profile.exposure_time = 3.5;
  MachineFile machine = sim2k();
  ContractSubject about = an_archive();
  about.left = 40;
  about.columns = 40;
  const auto contract = make_contract(profile, machine, about);
  ASSERT_TRUE(contract) << contract.error().message();
  EXPECT_EQ(contract->plan.test.column(2), 60U);
  EXPECT_EQ(contract->plan.exposure, std::chrono::milliseconds(3500));
  EXPECT_EQ(contract->cure_depth, cure_depth(profile, Irradiance(machine.power_mw_cm2), std::chrono::seconds(2)));
  EXPECT_THAT(lines_of(*contract), HasSubstr("\ntest       strips along x, from where the object begins: 0.0 to 0.5 mm "
                                             "2 s, 0.5 to 1.0 mm 2.5 s, 1.0 to 1.5 mm 3 s, 1.5 to 2.0 mm 3.5 s\n"));
  about.columns = 3;
  EXPECT_THAT(std::string(make_contract(profile, machine, about).error().message()), HasSubstr("the object has 3"));
  about = an_archive();
  about.grey = 0.5;
  EXPECT_TRUE(make_contract(profile, machine, about)) << "its panel shows grey";
  machine.panel.grey = {.exposures = 3};
  EXPECT_THAT(std::string(make_contract(profile, machine, about).error().message()), HasSubstr("print without grey"));
  about.grey = 0;
  EXPECT_TRUE(make_contract(profile, machine, about));
  profile.exposure_test.seconds[1] = 2.05;
  EXPECT_THAT(std::string(make_contract(profile, machine, about).error().message()),
              HasSubstr("2.05 s is 0.05 s more than 2 s, this printer's lamp is lit for 0.1 s at least"));
  profile.adaptive = true;
  EXPECT_THAT(std::string(make_contract(profile, machine, about).error().message()), HasSubstr("layers of one height"));
}

TEST(Contract, OfAScanHasNoDoubts) {
  ContractSubject scan = an_archive();
  scan.is_archive = false;
  EXPECT_EQ(make_contract(standard_profile(), sim2k(), scan)->doubts, 0);
}

TEST(Contract, LinesGiveEachValueWithItsUnitAndSource) {
  PrintProfile profile = standard_profile();
  set_value(profile, kPrintFields[index_of(PrintKey::kExposureTime)], 3.5, ValueSource::kPerson);
  set_value(profile, kPrintFields[index_of(PrintKey::kLayerHeight)], 0.05, ValueSource::kArchive);
  const std::string all = lines_of(*make_contract(profile, sim2k(), an_archive()));
  EXPECT_THAT(all, HasSubstr("1.0 x 0.5 x 2.0 mm, 40 layers, 0.0 ml"));
  EXPECT_THAT(all, HasSubstr("layer_height 0.05 mm, initial_layer_height 0.05 mm (archive)"));
  EXPECT_THAT(all,
              HasSubstr("bottom_layer_count 5, initial_exposure_time 30 s, faded_layers 8 (profile), exposure_time "
                        "3.5 s (person)"));
  EXPECT_THAT(all, Not(HasSubstr("printer")));
}

TEST(Contract, NamesWhoIsToBlameForAValueThatThePrinterCantDo) {
  PrintProfile profile = standard_profile();
  profile.archive = "part.zip";
  const auto refusal = [&](double speed, ValueSource source) {
    set_value(profile, kPrintFields[index_of(PrintKey::kLiftSpeed)], speed, source);
    const auto made = make_contract(profile, sim2k(), an_archive());
    return std::string(made ? "made" : made.error().message());
  };
  EXPECT_EQ(refusal(60, ValueSource::kArchive), "made");
  EXPECT_THAT(refusal(999, ValueSource::kArchive), HasSubstr("part.zip: lift_speed is 999 mm/min"));
  EXPECT_THAT(refusal(999, ValueSource::kProfile), HasSubstr("profile standard: lift_speed is 999 mm/min"));
  EXPECT_EQ(refusal(999, ValueSource::kPerson).substr(0, 10), "lift_speed");
  set_value(profile, kPrintFields[index_of(PrintKey::kLiftSpeed)], 60, ValueSource::kProfile);
  set_value(profile, kPrintFields[index_of(PrintKey::kRetractHeight2)], 30, ValueSource::kArchive);
  EXPECT_THAT(std::string(make_contract(profile, sim2k(), an_archive()).error().message()),
              HasSubstr("part.zip: retract_height2 is 30 mm, allowed is at most the whole lift"));
}

TEST(PrintValue, IsANumberInItsRangeOrTakenBack) {
  const PrintField& layers = *find_print_field("bottom_layer_count");
  EXPECT_EQ(parse_print_value(layers, "7").value(), 7);
  EXPECT_EQ(parse_print_value(layers, "").value(), std::nullopt);
  for (const char* wrong : {"7.5", "0", "101", "many", "nan", "1e9", " 7"}) {
    const auto refused = parse_print_value(layers, wrong);
    ASSERT_FALSE(refused) << wrong;
    EXPECT_THAT(std::string(refused.error().message()), HasSubstr("allowed is a whole number from 1 to 100 layers"));
  }
  PrintValues values;
  EXPECT_TRUE(parse_assignment("exposure_time=3.25", values));
  EXPECT_EQ(values[index_of(PrintKey::kExposureTime)], 3.25);
  EXPECT_FALSE(parse_assignment("layer_height=0.1", values)) << "it needs other masks";
  EXPECT_FALSE(parse_assignment("exposure_time", values));
  EXPECT_FALSE(parse_assignment("expo=3", values));
}

}  // namespace
}  // namespace plumbline::firmware
