#include "firmware/state/state_line.hpp"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <memory>
#include <string>

#include "firmware/io/text/json_cursor.hpp"
#include "firmware/io/wall_clock.hpp"
#include "firmware/messages/printer_code.hpp"
#include "tests/firmware/support/job_fixture.hpp"

namespace plumbline::firmware {
namespace {

using ::testing::HasSubstr;

/// Fills a text with the character that takes most room in JSON.
template <std::size_t Capacity>
void fill(FixedText<Capacity>& text) {
  assign(text, std::string(Capacity - 1, '"'));
}

/// As long as can be: eight facts with the longest names, and a name.
Told longest_told() {
  constexpr double kLong = 1234567.891;
  return {ToldCode::kTooHighOnSupports,
          {{PrinterFact::kPanelColumns, kLong},
           {PrinterFact::kPanelWidthMm, kLong},
           {PrinterFact::kPanelDepthMm, kLong},
           {Fact::kAvailableMib, kLong},
           {PrinterFact::kResinLeastC, kLong},
           {PrinterFact::kLampLimitC, kLong},
           {PrinterFact::kSpeedMmMin, kLong},
           {PrinterFact::kLimitMmMin, kLong}},
          std::string(39, '"')};
}

/// A record in which everything is as long as can be.
std::unique_ptr<PrinterRecord> longest_record() {
  auto record = std::make_unique<PrinterRecord>();
  fill(record->printer);
  fill(record->address);
  fill(record->message);
  fill(record->question);
  record->has_stick = record->has_job_file = true;
  record->scan_count = PrinterRecord::kMostScans;
  for (ScanRecord& scan : record->scans) {
    fill(scan.name);
    fill(scan.problem);
    scan.told = longest_told();
    scan.bytes = ~std::uint64_t{0};
    scan.files = 64;
    scan.picture = ~std::uint32_t{0};
  }
  fill(record->folder);
  record->folder_count = record->folders.size();
  for (FolderRecord& folder : record->folders) {
    fill(folder.name);
    folder.entries = ~std::uint32_t{0};
  }
  record->left_out.files = record->left_out.folders = record->left_out.partitions = ~std::size_t{0};
  fill(record->left_out.text);
  record->left_out.told = longest_told();
  UploadRecord& upload = record->upload.emplace();
  upload.number = ~std::uint32_t{0};
  upload.bytes = upload.received = ~std::uint64_t{0};
  fill(upload.name);
  fill(upload.problem);
  upload.told = record->message_told = record->question_told = longest_told();
  StoredRecord& stored = record->stored.emplace();
  stored.bytes = ~std::uint64_t{0};
  fill(stored.name);
  JobRecord& job = record->job.emplace();
  fill(job.scan);
  for (auto& file : job.files) fill(file);
  job.file_count = job.files.size();
  fill(job.profile);
  for (SupportPlaces& places : job.supports.places) {
    places.list.fill({-123.4567890123456, -123.4567890123456, -123.4567890123456, 12.34567890123456});
    places.count = 32;
  }
  job.scale = 1.2345678901234567e-5;
  record->result = PrintState::kSuspended;
  for (auto& profile : record->profiles) fill(profile);
  record->profile_count = record->profiles.size();
  Contract& contract = record->sliced.emplace();
  contract.width_mm = contract.depth_mm = contract.height_mm = 1999.999;
  contract.rotation_deg.fill(-359.999);
  contract.resin_ml = 12345.678;
  contract.time = std::chrono::hours(99999);
  contract.plan.layers = ~std::uint32_t{0};
  contract.plan.layer_height = Distance::micrometres(123.456);
  contract.sources.fill(ValueSource::kPrinter);
  contract.plan.test.count = ExposureTest::kMostStrips;
  contract.plan.test.exposures.fill(std::chrono::nanoseconds(119'123'456'789));
  for (auto& value : record->job->values) value = 299.9999;
  record->slicing = SlicingRecord{Stage::kWindingTree, 0.123, false, 0.4567};
  record->proposals.emplace().fill({{-359.9, -359.9}, 1, 1.23456e29, 1.23456e29, 1.23456e29, 1.23456e29, 1.23456e29});
  PrintStatus status;
  status.state = PrintState::kPrinting;
  status.layers = status.layer = ~std::uint32_t{0};
  status.slack = nanoseconds(123456789);
  status.question_told = longest_told();
  record->set_progress(status, 1'900'000'000);
  record->resin = ResinRecord{12345.678, 20000};
  for (CheckResult& check : record->checks) {
    check.outcome = CheckOutcome::kWarned;
    fill(check.detail);
    check.told = longest_told();
  }
  for (std::size_t i = 0; i < PrinterRecord::kMostFindings; ++i) {
    record->add_finding(Severity::kWarning, std::string(1000, '"'), longest_told());
  }
  record->set_fault(FaultCode::kJournalOfAnother, std::string(1000, '"'), std::string(1000, '"'), longest_told());
  return record;
}

TEST(StateLine, GivesNoTimeOfDayWithoutASetClock) {
  EXPECT_EQ(known_time(0), 0);
  EXPECT_EQ(known_time(kEarliestTime - 1), 0);
  EXPECT_EQ(known_time(kEarliestTime), kEarliestTime);
  PrinterRecord record;
  PrintStatus status;
  status.state = PrintState::kPrinting;
  status.remaining = std::chrono::minutes(5);
  record.set_progress(status, known_time(80));
  const auto line = std::make_unique<StateLine>();
  ASSERT_TRUE(write_state_line(*line, record, 1));
  EXPECT_EQ(json_member(*json_member(line->view(), "progress"), "ends_at"), "null");
  EXPECT_EQ(json_member(*json_member(line->view(), "progress"), "left_s"), "300");
}

TEST(StateLine, HasWhatThePrinterRemembers) {
  PrinterRecord record;
  const auto line = std::make_unique<StateLine>();
  ASSERT_TRUE(write_state_line(*line, record, 1));
  EXPECT_EQ(json_member(line->view(), "machine"), "null");
  const TemporaryFolder folder;
  MachineRecord machine = MachineRecord::open(folder / ".", 180).value();
  ASSERT_TRUE(machine.add_fault(FaultCode::kStickGone, ""));
  machine.feels(TemperatureSite::kLamp, Celsius(31.6));
  machine.feels(TemperatureSite::kResin, Celsius(-2.4));
  record.machine = &machine;
  const auto another = std::make_unique<StateLine>();
  ASSERT_TRUE(write_state_line(*another, record, 1));
  EXPECT_EQ(json_member(another->view(), "machine"),
            "{\"resin_ml\": null, \"filled_ml\": null, \"tank_ml\": 180, \"lamp_h\": 0, \"film_layers\": 0, "
            "\"hottest_c\": {\"lamp\": null, \"resin\": null, \"board\": null}, \"unseen_faults\": [\"PL-107\"]}")
      << "what was read at rest is not of the highest";
  EXPECT_EQ(json_member(line->view(), "temperatures_c"), "{\"lamp\": null, \"resin\": null, \"board\": null}");
  EXPECT_EQ(json_member(another->view(), "temperatures_c"), "{\"lamp\": 32, \"resin\": -2, \"board\": null}");
}

TEST(StateLine, HasTheAddressOfThePage) {
  PrinterRecord record;
  const auto line = std::make_unique<StateLine>(), another = std::make_unique<StateLine>();
  ASSERT_TRUE(write_state_line(*line, record, 1));
  EXPECT_EQ(json_member(line->view(), "address"), "null");
  assign(record.address, "http://192.168.1.2:8080");
  ASSERT_TRUE(write_state_line(*another, record, 1));
  EXPECT_EQ(json_member(another->view(), "address"), "\"http://192.168.1.2:8080\"");
}

TEST(StateLine, OfTheLongestRecordFits) {
  const TemporaryFolder folder;
  auto prints = KeptPrints::open(folder / ".", [](std::string_view /*text*/) {});
  ASSERT_TRUE(prints);
  KeptPrint print;
  print.result = static_cast<std::uint32_t>(PrintState::kSuspended);
  print.scan = print.profile = short_name(std::string(100, '"'));
  print.layers = print.layers_done = ~std::uint32_t{0};
  print.ended_at = 1'900'000'000;
  print.resin_ml = 12345.678;
  for (std::size_t i = 0; i < KeptPrints::kMost; ++i) {
    ASSERT_TRUE(prints->keep(print, [](TextSink& out) { return out.write("{}"); }, {}));
  }
  MachineRecord machine(12345.678);
  for (std::size_t i = 0; i < MachineRecord::kMostFaults; ++i)
    ASSERT_TRUE(machine.add_fault(FaultCode::kStickGone, ""));
  for (std::size_t i = 0; i < kTemperatureSiteCount; ++i)
    machine.felt(static_cast<TemperatureSite>(i), Celsius(149.999));
  const auto record = longest_record();
  record->prints = &*prints;
  record->machine = &machine;
  const auto line = std::make_unique<StateLine>();
  ASSERT_TRUE(write_state_line(*line, *record, ~std::uint64_t{0})) << "more than " << kLongestLine << " bytes";
  EXPECT_TRUE(line->view().ends_with("}\n"));
  EXPECT_GT(line->view().size(), kLongestLine / 2) << "the bound is not far above what is needed";
  JsonCursor cursor(line->view());
  EXPECT_TRUE(cursor.take_value(6)) << "it is JSON";
  EXPECT_TRUE(cursor.at_end());
}

TEST(StateLine, SaysWhatThePrinterTakes) {
  PrinterRecord record;
  const auto commands = [&record] {
    StateLine line;
    EXPECT_TRUE(write_state_line(line, record, 1));
    return std::string(json_member(line.view(), "commands").value_or("none"));
  };
  record.state = PrintState::kOffered;
  EXPECT_EQ(commands(), "[]") << "nobody waits for an answer, so a command would be lost";
  record.waits = true;
  record.job.emplace();
  EXPECT_EQ(commands(), R"(["start", "cancel", "set", "propose"])") << "there is one scan";
  record.scan_count = 2;
  EXPECT_EQ(commands(), R"(["start", "cancel", "choose", "set", "propose"])");
  record.folder_count = 1;
  EXPECT_EQ(commands(), R"(["start", "cancel", "choose", "set", "propose", "open"])");
  record.folder_count = 0;
  assign(record.folder, "prints");
  EXPECT_EQ(commands(), R"(["start", "cancel", "choose", "set", "propose", "open"])") << "back up";
  record.folder.clear();
  assign(record.job->files[0], "bust.sl1");
  EXPECT_EQ(commands(), R"(["start", "cancel", "choose", "set"])") << "it stands as it was sliced";
  record.state = PrintState::kPlateInUse;
  EXPECT_EQ(commands(), R"(["plate-empty"])");
  record.state = PrintState::kIdle;
  EXPECT_EQ(commands(), "[]");
  record.has_stick = true;
  EXPECT_EQ(commands(), R"(["offer"])");
  record.waits = false;
  record.state = PrintState::kPrinting;
  EXPECT_EQ(commands(), R"(["pause", "cancel"])");
  EXPECT_THAT(what_it_takes(record).c_str(), HasSubstr("'printing'. It takes pause, cancel"));
  record.state = PrintState::kFinishing;
  EXPECT_EQ(commands(), "[]");
}

TEST(StateLine, HasWhatIsToldAsACodeWithItsValues) {
  PrinterRecord record;
  Remedies remedies;
  remedies.add("supports", "auto");
  record.add_finding(Severity::kWarning, "3 islands",
                     {PrinterCode::kIsland, {{Fact::kCount, 3}, {Fact::kAreaMm2, 113.25}, {Fact::kLayer, 702}}},
                     remedies, {.mm = {{{1, 2, 35.1}}}, .count = 1});
  record.add_finding(Severity::kNote, "no code");
  record.question_told = {PrinterCode::kProfileUnknown, {}, "fine"};
  StateLine line;
  ASSERT_TRUE(write_state_line(line, record, 1));
  EXPECT_EQ(json_member(line.view(), "findings"),
            R"([{"severity": "warning", "text": "3 islands", "told": {"code": "island", "values": {"count": 3, )"
            R"("area_mm2": 113.25, "layer": 702}}, "remedies": [{"key": "supports", "value": "auto"}], )"
            R"("places_mm": [[1, 2, 35.1]]}, {"severity": "note", "text": "no code", "told": null, "remedies": [], )"
            R"("places_mm": []}])");
  EXPECT_EQ(json_member(line.view(), "question_told"), R"({"code": "profile_unknown", "values": {}, "name": "fine"})");
  EXPECT_EQ(json_member(line.view(), "message_told"), "null");
}

TEST(StateLine, SaysWhatIsUploadedAndHowMuchMayBe) {
  PrinterRecord record;
  const auto member = [&record](std::string_view name) {
    StateLine line;
    EXPECT_TRUE(write_state_line(line, record, 1));
    return std::string(json_member(line.view(), name).value_or("none"));
  };
  EXPECT_EQ(member("upload_limit"), "0") << "this printer takes none";
  EXPECT_EQ(member("upload"), "null");
  record.most_upload_bytes = 1000;
  EXPECT_EQ(member("upload_limit"), "1000");
  record.state = PrintState::kPrinting;
  EXPECT_EQ(member("upload_limit"), "0");
  record.state = PrintState::kPlateInUse;
  record.upload.emplace();
  record.upload->number = 3;
  record.upload->bytes = 20;
  record.upload->received = 10;
  assign(record.upload->name, "a.ply");
  EXPECT_EQ(member("upload_limit"), "0") << "one at a time";
  EXPECT_EQ(
      member("upload"),
      R"({"number": 3, "stage": "coming", "name": "a.ply", "bytes": 20, "received": 10, "problem": null, "told": null})");
  record.upload->stage = UploadRecord::Stage::kKept;
  EXPECT_EQ(member("upload_limit"), "1000");
  record.waits = true;
  assign(record.stored.emplace().name, "a.ply");
  record.state = PrintState::kIdle;
  EXPECT_EQ(member("commands"), R"(["offer", "remove"])");
  record.stored->bytes = 20;
  EXPECT_EQ(member("stored"), R"({"name": "a.ply", "bytes": 20})");
  record.state = PrintState::kFault;
  EXPECT_EQ(member("commands"), R"(["seen", "remove"])");
  record.waits = false;
  EXPECT_EQ(member("commands"), "[]") << "nobody is there to take it";
  record.state = PrintState::kPrinting;
  EXPECT_EQ(member("commands"), R"(["pause", "cancel"])") << "removing could make a mask late";
  record.stored.reset();
  EXPECT_EQ(member("stored"), "null");
}

TEST(CommandRules, WhatHasBeenSlicedGoesBackToItsSettingsWhileItsScanIsThere) {
  PrinterRecord record;
  record.state = PrintState::kOffered;
  record.waits = record.has_stick = true;
  record.job.emplace();
  record.job_id = 7;
  EXPECT_FALSE(takes(record, Command::kSettings)) << "they are shown already";
  record.sliced.emplace();
  EXPECT_TRUE(takes(record, Command::kSettings));
  EXPECT_TRUE(takes(record, Command::kSet));
  EXPECT_TRUE(is_meant(record, Command::kSettings, 7)) << "the job's id";
  EXPECT_FALSE(is_meant(record, Command::kSettings, 8));
  EXPECT_FALSE(answers_question(record, Command::kSettings)) << "it starts nothing";
  EXPECT_EQ(button_of(Command::kSettings), std::nullopt);
  record.has_stick = false;
  EXPECT_FALSE(takes(record, Command::kSettings));
  EXPECT_TRUE(takes(record, Command::kSet)) << "exposures need no scan";
  record.scans_uploaded = true;
  record.scan_count = 1;
  assign(record.scans[0].name, "a.ply");
  record.scans[0].bytes = 20;
  EXPECT_FALSE(takes(record, Command::kSettings));
  record.stored.emplace().bytes = 20;
  assign(record.stored->name, "a.ply");
  EXPECT_TRUE(takes(record, Command::kSettings));
  record.stored->bytes = 21;
  EXPECT_FALSE(takes(record, Command::kSettings)) << "another one has been uploaded";
  record.state = PrintState::kPrinting;
  record.stored->bytes = 20;
  EXPECT_FALSE(takes(record, Command::kSettings));
}

// A command that a state takes must be an event that this state knows, or nobody would carry it out.
TEST(CommandRules, AnEventThatAStateTakesChangesIt) {
  PrinterRecord record;
  record.waits = record.has_stick = true;
  for (std::size_t i = 0; i < kPrintStateCount; ++i) {
    record.state = static_cast<PrintState>(i);
    if (at_rest(record.state)) continue;  // the daemon's own: daemon_test and state_test go through them
    const auto changes = [&](PrintEvent event) { return next(record.state, event) != record.state; };
    EXPECT_EQ(takes(record, Command::kCancel), changes(PrintEvent::kCancelAsked)) << to_string(record.state);
    EXPECT_EQ(takes(record, Command::kResume), changes(PrintEvent::kResumeAsked)) << to_string(record.state);
  }
}

}  // namespace
}  // namespace plumbline::firmware
