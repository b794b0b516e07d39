/// The daemon on the plant: sticks, choices, interrupted prints, job after job in the same memory.

#include <gmock/gmock.h>
#include <gtest/gtest.h>
#include <sys/stat.h>

#include "tests/hil/session_rig.hpp"

namespace plumbline::firmware {
namespace {

using namespace std::chrono_literals;
using ::testing::Contains;
using ::testing::ElementsAre;
using ::testing::HasSubstr;
using ::testing::Not;
using ::testing::StartsWith;
using enum PrintState;

TEST(Daemon, PrintsTheOnlyScanOnAStickAndIsReadyForTheNext) {
  DaemonRig rig;
  rig.put_scan("ball.ply");
  rig.user.on_words.emplace("ready", [&] {
    if (rig.user.reports.empty()) rig.plant.plug_stick(rig.stick());
  });
  rig.user.on_printed = [&] { rig.plant.press(EventKind::kShutdownRequested); };
  ASSERT_TRUE(rig.run());
  ASSERT_EQ(rig.user.reports.size(), 1U);
  EXPECT_EQ(rig.user.reports[0].state, kFinished) << rig.user.reports[0].fault_message.c_str();
  EXPECT_THAT(rig.user.scans, ElementsAre("ball.ply"));
  EXPECT_THAT(rig.user.profiles, ElementsAre("standard"));
  EXPECT_THAT(rig.user.said, ElementsAre(HasSubstr("start = \"on_stick\""), "ready", HasSubstr("reading ball.ply"),
                                         HasSubstr("only 4 mm long"), "the stick may be pulled",
                                         HasSubstr("is the plate empty?"), "shut down"));
  EXPECT_EQ(rig.arena.used(), 0U);
}

TEST(Daemon, DoesNotNeedTheStickOnceTheScanIsRead) {
  DaemonRig rig;
  rig.put_scan("ball.ply");
  rig.plant.plug_stick(rig.stick());
  rig.plant.inject(parse_fault("stick.pulled@layer=3").value());
  rig.user.on_printed = [&] { rig.plant.press(EventKind::kShutdownRequested); };
  ASSERT_TRUE(rig.run());
  ASSERT_EQ(rig.user.reports.size(), 1U);
  EXPECT_EQ(rig.user.reports[0].state, kFinished);
}

TEST(Daemon, PrintsTheNextStickAfterOneWasPulledWhileItWasRead) {
  auto settings = session_plant();
  settings.stick_bytes_per_second = 2e4;  // some 100 kB take 5 s
  DaemonRig rig(settings);
  rig.put_scan("ball.ply");
  rig.plant.plug_stick(rig.stick());
  rig.plant.timeline().at(TimePoint() + 2s, [&] { rig.plant.pull_stick(); });
  rig.user.on_words.emplace("PL-107", [&] {
    EXPECT_EQ(rig.arena.used(), 0U);
    rig.plant.plug_stick(rig.stick());
  });
  rig.user.on_printed = [&] { rig.plant.press(EventKind::kShutdownRequested); };
  ASSERT_TRUE(rig.run());
  EXPECT_THAT(rig.user.said, Contains(HasSubstr("PL-107, stick pulled")));
  ASSERT_EQ(rig.user.reports.size(), 1U);
  EXPECT_EQ(rig.user.reports[0].state, kFinished);
}

TEST(Daemon, ShowsTheFaultOfAPulledStickUntilSomebodyHasSeenItAlsoAfterARestart) {
  auto settings = session_plant();
  settings.stick_bytes_per_second = 2e4;
  DaemonRig rig(settings);
  rig.put_scan("ball.ply");
  rig.plant.plug_stick(rig.stick());
  rig.plant.timeline().at(TimePoint() + 2s, [&] { rig.plant.pull_stick(); });
  rig.plant.timeline().at(TimePoint() + 10min, [&] { rig.plant.press(EventKind::kShutdownRequested); });
  auto state = kIdle;
  rig.user.on_idle = [&] { state = rig.record.state; };
  ASSERT_TRUE(rig.run());
  EXPECT_EQ(state, kFault) << "ten minutes after the stick has gone";
  EXPECT_THAT(rig.user.said, Not(Contains("ready")));

  for (int restart = 0; restart < 2; ++restart) {
    rig.user.said.clear();
    rig.record = PrinterRecord();
    rig.plant.timeline().at(rig.plant.now() + 1min, [&] {
      ASSERT_TRUE(rig.record.fault);
      EXPECT_EQ(rig.record.fault->code, FaultCode::kStickGone);
      rig.plant.press(restart == 0 ? EventKind::kShutdownRequested : EventKind::kStartPressed);
    });
    if (restart == 1) rig.user.on_words.emplace("ready", [&] { rig.plant.press(EventKind::kShutdownRequested); });
    ASSERT_TRUE(rig.run());
    EXPECT_THAT(rig.user.said.at(1), HasSubstr("PL-107, stick pulled"));
  }
  EXPECT_THAT(rig.user.said, Contains("ready")) << "a button has taken it";
  EXPECT_EQ(MachineRecord::open(rig.state(), 1)->fault_count(), 0U);
}

TEST(Daemon, PrintsAFolderOfScansAfterItsStickWasPulledWhileTheyWereRead) {
  auto settings = session_plant();
  settings.stick_bytes_per_second = 2e4;  // some 100 kB take 5 s
  DaemonRig rig(settings);
  std::filesystem::create_directory(rig.stick() + "/ball");
  rig.put_scan("ball/scan_1.ply", 2, 2000);
  rig.put_scan("ball/scan_2.ply", 2, 2100);
  write_text(rig.stick() + "/job.toml", "[job]\nscan = 'ball'\n");
  rig.plant.plug_stick(rig.stick());
  rig.plant.timeline().at(TimePoint() + 3s, [&] { rig.plant.pull_stick(); });
  rig.user.on_words.emplace("PL-107", [&] {
    EXPECT_EQ(rig.arena.used(), 0U);
    rig.plant.plug_stick(rig.stick());
  });
  rig.user.on_printed = [&] { rig.plant.press(EventKind::kShutdownRequested); };
  ASSERT_TRUE(rig.run());
  EXPECT_THAT(rig.user.said, Contains(HasSubstr("PL-107, stick pulled")));
  EXPECT_THAT(rig.user.scans, ElementsAre("ball/scan_1.ply and 1 more"));
  EXPECT_EQ(rig.user.reports[0].state, kFinished);
}

TEST(Daemon, WaitsForSomebodyIfOnlyNamesSayThatScansAreOne) {
  DaemonRig rig;  // a rig's: a stick with one scan starts its print
  std::filesystem::create_directory(rig.stick() + "/ball");
  rig.put_scan("ball/scan_1.ply", 2, 2000);
  rig.put_scan("ball/scan_2.ply", 2, 2100);
  rig.plant.plug_stick(rig.stick());
  rig.user.on_words.emplace("2 scans as one: ball/scan_1.ply and 1 more. Press start",
                            [&] { rig.plant.press(EventKind::kShutdownRequested); });
  ASSERT_TRUE(rig.run());
  EXPECT_TRUE(rig.user.scans.empty());
}

TEST(Daemon, FollowsTheJobFile) {
  DaemonRig rig;
  rig.put_scan("a.ply");
  rig.put_scan("b.ply");
  write_text(
      rig.stick() + "/job.toml",
      "[job]\nscan = 'b.ply'\nprofile = 'draft'\nsupports = 'none'\n[placement]\nscale = 1.5\nlayer_height = 0.2\n");
  rig.plant.plug_stick(rig.stick());
  rig.user.on_printed = [&] { rig.plant.press(EventKind::kShutdownRequested); };
  ASSERT_TRUE(rig.run());
  EXPECT_THAT(rig.user.scans, ElementsAre("b.ply"));
  EXPECT_THAT(rig.user.profiles, ElementsAre("draft"));
  EXPECT_EQ(rig.user.reports.at(0).layers, 30U) << "a ball of 6 mm";
}

// Regression: it left out a stray piece and flipped normals without reporting it.
TEST(Daemon, SaysWhatItLeftOutOfAScanAndWhichNormalsItTurned) {
  DaemonRig rig;
  std::vector<ScanPoint> scan = sphere_scan(4000, 2);
  for (std::size_t i = 100; i < 300; ++i) {
    for (float* n : {&scan[i].nx, &scan[i].ny, &scan[i].nz}) *n = -*n;
  }
  for (int i = 0; i < 36; ++i) {
    scan.push_back({6 + 0.11 * (i % 6), 0.11 * (i / 6), 0, 0, 0, 1});  // a bit of the table
  }
  write_scan(rig.stick() + "/ball.ply", scan);
  rig.plant.plug_stick(rig.stick());
  rig.user.on_printed = [&] { rig.plant.press(EventKind::kShutdownRequested); };
  ASSERT_TRUE(rig.run());
  EXPECT_THAT(rig.user.said, Contains(HasSubstr("stray piece")));
  EXPECT_THAT(rig.user.said, Contains(HasSubstr("% of the normals pointed into the object and were flipped")));
}

TEST(Daemon, ReportsAMistakeInAJobFileAndStaysReady) {
  DaemonRig rig;
  rig.put_scan("a.ply");
  write_text(rig.stick() + "/job.toml", "[job]\nscan = 'a.ply'\nscael = 2\n");
  rig.plant.plug_stick(rig.stick());
  rig.user.on_words.emplace("PL-106", [&] { rig.plant.press(EventKind::kShutdownRequested); });
  ASSERT_TRUE(rig.run());
  EXPECT_THAT(rig.user.said, Contains(HasSubstr("job.toml:3: [job] scael: unknown key")));
  EXPECT_EQ(rig.fault, FaultCode::kBadSetting);
}

/// What the daemon says about a stick whose job it refuses.
std::string refusal_of(DaemonRig& rig) {
  rig.plant.plug_stick(rig.stick());
  rig.user.on_words.emplace("PL-", [&] { rig.plant.press(EventKind::kShutdownRequested); });
  EXPECT_TRUE(rig.run());
  EXPECT_TRUE(rig.user.states.empty()) << "nothing was printed";
  for (const auto& line : rig.user.said) {
    if (line.starts_with("PL-")) return line;
  }
  return {};
}

TEST(Daemon, NamesTheLineOfAJobFileThatIsNotToml) {
  DaemonRig rig;
  rig.put_scan("a.ply");
  write_text(rig.stick() + "/job.toml", "[job]\nscan = 'a.ply'\nscale 2\n");
  EXPECT_THAT(refusal_of(rig), StartsWith("PL-106, wrong setting: job.toml:3: not TOML"));
}

TEST(Daemon, CallsAMissingProfileAWrongSetting) {
  DaemonRig rig;
  rig.put_scan("a.ply");
  write_text(rig.stick() + "/job.toml", "[job]\nscan = 'a.ply'\nprofile = 'thicc'\n");
  EXPECT_THAT(refusal_of(rig), StartsWith("PL-106, wrong setting: no profile is called thicc"));
}

TEST(Daemon, FindsAJobFileInAnyCase) {
  DaemonRig rig;
  for (const char* name : {"a.ply", "b.ply"}) rig.put_scan(name);
  write_text(rig.stick() + "/Job.TOML", "[job]\nscan = 'b.ply'\nsupports = 'none'\n[placement]\nscale = 0.5\n");
  rig.plant.plug_stick(rig.stick());
  rig.user.on_printed = [&] { rig.plant.press(EventKind::kShutdownRequested); };
  ASSERT_TRUE(rig.run());
  EXPECT_THAT(rig.user.scans, ElementsAre("b.ply"));
  EXPECT_EQ(rig.user.reports.at(0).layers, 40U) << "a ball of 4 mm, at half of its size";
}

struct OddStick {
  const char* what;
  std::function<void(const std::string& stick)> make;
  const char* said;
};

TEST(Daemon, NamesWhatIsOddAboutAJobFileAndPrintsNothing) {
  const auto job = [](const std::string& path) { write_text(path, "[job]\nscan = 'a.ply'\n"); };
  const std::vector<OddStick> odd = {
      {"pipe", [](const auto& stick) { ASSERT_EQ(::mkfifo((stick + "/Job.toml").c_str(), 0600), 0); },
       "PL-106, wrong setting: Job.toml: a pipe, not a file"},
      {"link", [](const auto& stick) { std::filesystem::create_symlink("/etc/passwd", stick + "/job.toml"); },
       "PL-106, wrong setting: job.toml: a symbolic link, not a file"},
      {"folder", [](const auto& stick) { std::filesystem::create_directory(stick + "/JOB.TOML"); },
       "PL-106, wrong setting: JOB.TOML: a folder, not a file"},
      {"two", [&](const auto& stick) { job(stick + "/job.toml"), job(stick + "/Job.toml"); }, "the stick has two jobs"},
      {"ending", [&](const auto& stick) { job(stick + "/job.toml.txt"); },
       "PL-106, wrong setting: job.toml.txt: looks like the stick's job"},
      {"scan", [](const auto& stick) { ASSERT_EQ(::mkfifo((stick + "/b.ply").c_str(), 0600), 0); },
       "PL-101, scan can't be read: b.ply: a pipe, not a file"},
      {"scan of the job",
       [](const auto& stick) {
         std::filesystem::create_symlink("/etc/passwd", stick + "/b.ply");
         write_text(stick + "/job.toml", "[job]\nscan = 'b.ply'\n");
       },
       "PL-101, scan can't be read: b.ply: a symbolic link"},
  };
  for (const auto& one : odd) {
    SCOPED_TRACE(one.what);
    DaemonRig rig;
    rig.put_scan("a.ply");
    one.make(rig.stick());
    EXPECT_THAT(refusal_of(rig), HasSubstr(one.said));
  }
}

// A name with a line break forged "PL-301, lamp stuck on" in the log.
TEST(Daemon, ShowsNamesOfAStickOnOneLineAndWithoutControls) {
  constexpr const char* kForged = "a\nplumblined: PL-301, lamp stuck on: pull the plug\x1b[31m.ply";
  {
    DaemonRig rig;
    rig.start = StartChoice::kOnRequest;
    rig.put_scan(kForged);
    rig.plant.plug_stick(rig.stick());
    rig.user.on_words.emplace("Press start", [&] { rig.plant.press(EventKind::kStartPressed); });
    rig.user.on_printed = [&] { rig.plant.press(EventKind::kShutdownRequested); };
    ASSERT_TRUE(rig.run());
    EXPECT_THAT(rig.user.scans.at(0), StartsWith("a\\x0aplumblined: PL-301"));
    for (const auto& line : rig.user.said) {
      EXPECT_EQ(line.find_first_of("\n\x1b"), std::string::npos) << line;
      EXPECT_THAT(line, Not(StartsWith("plumblined: PL-301")));
    }
  }
  DaemonRig rig;
  write_text(rig.stick() + "/job.toml", "[job]\nscan = \"a\\nplumblined: PL-301, lamp stuck on\\u001b[31m\\u202e\"\n");
  EXPECT_EQ(refusal_of(rig).find_first_of("\n\x1b\xe2"), std::string::npos);
}

// The warning about the unit was dropped.
TEST(Daemon, SaysThatAnObjectIsSuspiciouslySmall) {
  DaemonRig rig;
  rig.put_scan("ball.ply", 1, 3000);
  rig.plant.plug_stick(rig.stick());
  rig.user.on_printed = [&] { rig.plant.press(EventKind::kShutdownRequested); };
  ASSERT_TRUE(rig.run());
  EXPECT_THAT(rig.user.said,
              Contains(HasSubstr(
                  "the object is only 2 mm long. If that is wrong, choose a height or its unit under Settings.")));
}

TEST(Daemon, LetsTheUserChooseAScanWithTheButtons) {
  DaemonRig rig;
  for (const char* name : {"c.ply", "a.ply", "b.PLY", ".hidden.ply", "notes.md"}) rig.put_scan(name);
  write_text(rig.stick() + "/README.txt", "Scans of the bust, in mm\n");
  rig.plant.plug_stick(rig.stick());
  rig.user.on_words.emplace("scan 1 of 3: a.ply", [&] { rig.plant.press(EventKind::kPausePressed); });
  rig.user.on_words.emplace("scan 2 of 3: b.PLY", [&] { rig.plant.press(EventKind::kStartPressed); });
  rig.user.on_printed = [&] { rig.plant.press(EventKind::kShutdownRequested); };
  ASSERT_TRUE(rig.run());
  EXPECT_THAT(rig.user.scans, ElementsAre("b.PLY"));
}

TEST(Daemon, GivesUpACancelledChoiceAndAnUnreadableScan) {
  DaemonRig rig;
  rig.put_scan("a.ply");
  rig.put_scan("b.ply");
  rig.plant.plug_stick(rig.stick());
  rig.user.on_words.emplace("scan 1 of 2", [&] { rig.plant.press(EventKind::kCancelPressed); });
  rig.user.on_words.emplace("ready", [&] {
    rig.plant.pull_stick();
    std::filesystem::remove(rig.stick() + "/a.ply");
    write_text(rig.stick() + "/b.ply",
               "ply\nformat ascii 1.0\nelement vertex 5\nproperty float x\nproperty float y\nproperty float "
               "z\nend_header\n1 2 3\n");
    rig.plant.plug_stick(rig.stick());
  });
  rig.user.on_words.emplace("PL-102", [&] { rig.plant.press(EventKind::kShutdownRequested); });
  ASSERT_TRUE(rig.run());
  EXPECT_TRUE(rig.user.reports.empty());
  EXPECT_EQ(rig.fault, FaultCode::kNotAScan);
  EXPECT_EQ(rig.arena.used(), 0U);
}

TEST(Daemon, ReportsAnEmptyStick) {
  DaemonRig rig;
  rig.plant.plug_stick(rig.stick());
  rig.user.on_words.emplace("PL-103", [&] { rig.plant.press(EventKind::kShutdownRequested); });
  ASSERT_TRUE(rig.run());
  EXPECT_THAT(rig.user.said, Contains(HasSubstr("no scan or mesh on the stick")));
}

TEST(Daemon, ResumesAPrintAfterAPowerCutWithoutItsStick) {
  // The masks of an undisturbed print.
  std::vector<std::uint64_t> whole;
  {
    DaemonRig rig;
    rig.put_scan("ball.ply");
    rig.plant.plug_stick(rig.stick());
    rig.user.on_printed = [&] { rig.plant.press(EventKind::kShutdownRequested); };
    ASSERT_TRUE(rig.run());
    whole = rig.user.hashes.at(0);
  }
  auto settings = session_plant();
  settings.faults.push_back(parse_fault("power.cut@layer=12+1s").value());
  DaemonRig rig(settings);
  rig.put_scan("ball.ply");
  rig.plant.plug_stick(rig.stick());
  static_cast<void>(rig.run());
  ASSERT_EQ(rig.user.reports.size(), 1U);
  EXPECT_EQ(rig.user.reports[0].state, kSuspended);

  rig.plant.restore_power();
  rig.plant.pull_stick();
  rig.user.on_words.emplace("an interrupted print can go on", [&] { rig.plant.press(EventKind::kStartPressed); });
  rig.user.on_printed = [&] { rig.plant.press(EventKind::kShutdownRequested); };
  ASSERT_TRUE(rig.run());
  ASSERT_EQ(rig.user.reports.size(), 2U);
  EXPECT_EQ(rig.user.reports[1].state, kFinished) << rig.user.reports[1].fault_message.c_str();
  EXPECT_EQ(rig.user.reports[1].first_layer, 12U);
  EXPECT_EQ(rig.user.hashes[1], std::vector<std::uint64_t>(whole.begin() + 12, whole.end()));
  EXPECT_EQ(std::distance(std::filesystem::directory_iterator(rig.folder / "state"), {}), 1)
      << "the print is removed from the store; the machine's record stays";
}

TEST(Daemon, ReportsADamagedJournalAndDoesNotResume) {
  auto settings = session_plant();
  settings.faults.push_back(parse_fault("power.cut@layer=12").value());
  DaemonRig rig(settings);
  rig.put_scan("ball.ply");
  rig.plant.plug_stick(rig.stick());
  static_cast<void>(rig.run());
  rig.plant.restore_power();
  rig.plant.pull_stick();
  const std::string path = (rig.folder / "state") + "/journal";
  auto journal = read_text(path);
  for (const std::size_t copy : {std::size_t{0}, journal.size() / 2})
    journal[copy + 5 * Journal::kRecordBytes + 20] ^= 1;
  write_text(path, journal);
  const auto lights = rig.plant.lights().size();
  int asked = 0;
  rig.user.on_words.emplace("an interrupted print can go on", [&] {
    rig.plant.press(asked++ == 0 ? EventKind::kStartPressed : EventKind::kCancelPressed);
  });
  rig.user.on_words.emplace("PL-120", [&] { rig.plant.press(EventKind::kStartPressed); });
  rig.user.on_words.emplace("is the plate empty?", [&] { rig.plant.press(EventKind::kShutdownRequested); });
  ASSERT_TRUE(rig.run());
  EXPECT_THAT(rig.user.said, Contains(HasSubstr("PL-120, journal damaged")));
  EXPECT_EQ(rig.plant.lights().size(), lights) << "nothing was lit";
  EXPECT_EQ(rig.user.reports.size(), 1U);
  EXPECT_FALSE(std::filesystem::exists(path)) << "the user gave it up";
}

constexpr std::chrono::milliseconds kGaps[] = {200ms, 400ms, 800ms};  // between two presses of one finger

// Regression: the second press began the print before once more, onto a plate that nobody had looked at.
TEST(Daemon, TakesNoSecondPressOnThePlateQuestionForTheNextOne) {
  for (const auto gap : kGaps) {
    SCOPED_TRACE(gap.count());
    DaemonRig rig;
    rig.start = StartChoice::kOnRequest;
    rig.put_scan("ball.ply", 1, 3000);
    rig.plant.plug_stick(rig.stick());
    bool begun = false, offered_again = false;
    rig.user.on_words.emplace("Press start to print it", [&] {
      if (!std::exchange(begun, true)) return rig.plant.press(EventKind::kStartPressed);
      offered_again = true;
      rig.plant.timeline().at(rig.plant.now() + 10s, [&] { rig.plant.press(EventKind::kShutdownRequested); });
    });
    rig.user.on_words.emplace("is the plate empty?", [&, gap] {
      rig.plant.press(EventKind::kStartPressed);
      rig.plant.timeline().at(rig.plant.now() + gap, [&] { rig.plant.press(EventKind::kStartPressed); });
    });
    ASSERT_TRUE(rig.run());
    EXPECT_TRUE(offered_again);
    EXPECT_EQ(rig.user.reports.size(), 1U);
  }
}

TEST(Daemon, SaysThatAPressCameTooSoonAndTakesTheNextOne) {
  DaemonRig rig;
  rig.start = StartChoice::kOnRequest;
  rig.put_scan("ball.ply", 1, 3000);
  rig.plant.plug_stick(rig.stick());
  bool pressed = false;
  rig.user.on_idle = [&] {
    if (rig.record.state == kOffered && !std::exchange(pressed, true)) rig.plant.press(EventKind::kStartPressed);
  };
  rig.user.on_words.emplace("within a second of the question", [&] {
    EXPECT_EQ(rig.record.message_told.code, Told(PrinterCode::kPressSoon).code);
    EXPECT_EQ(rig.record.state, kOffered);
    rig.plant.press(EventKind::kStartPressed);
  });
  rig.user.on_printed = [&] { rig.plant.press(EventKind::kShutdownRequested); };
  ASSERT_TRUE(rig.run());
  EXPECT_THAT(rig.user.said, Contains(HasSubstr("within a second of the question")));
  EXPECT_EQ(rig.user.reports.size(), 1U);
}

TEST(Daemon, TakesNoSecondPressOnPrintForTheQuestionAboutThePreview) {
  for (const auto gap : kGaps) {
    SCOPED_TRACE(gap.count());
    DaemonRig rig;
    rig.start = StartChoice::kAfterPreview;
    rig.put_scan("ball.ply", 1, 3000);
    rig.plant.plug_stick(rig.stick());
    int asked = 0;
    rig.user.on_words.emplace("Press start to print it", [&, gap] {
      if (++asked > 1) {
        rig.plant.timeline().at(rig.plant.now() + 10s, [&] { rig.plant.press(EventKind::kShutdownRequested); });
        return;
      }
      rig.plant.press(EventKind::kStartPressed);
      rig.plant.timeline().at(rig.plant.now() + gap, [&] { rig.plant.press(EventKind::kStartPressed); });
    });
    ASSERT_TRUE(rig.run());
    EXPECT_EQ(asked, 2) << "the preview was shown, and nobody has answered";
    EXPECT_TRUE(rig.user.reports.empty());
  }
}

TEST(Daemon, NamesEachJobAndEachQuestionAnew) {
  DaemonRig rig;
  rig.start = StartChoice::kAfterPreview;
  rig.put_scan("ball.ply", 1, 3000);
  rig.plant.plug_stick(rig.stick());
  std::vector<std::uint64_t> jobs, questions, prints;
  rig.user.on_words.emplace("Press start to print it", [&] {
    jobs.push_back(rig.record.job_id);
    questions.push_back(rig.record.asks);
    rig.plant.press(EventKind::kStartPressed);
  });
  rig.user.on_words.emplace("is the plate empty?", [&] {
    questions.push_back(rig.record.asks);
    rig.plant.press(jobs.size() < 4 ? EventKind::kStartPressed : EventKind::kShutdownRequested);
  });
  ASSERT_TRUE(rig.run());
  ASSERT_EQ(jobs.size(), 4U) << "two prints, and each was asked about twice";
  EXPECT_EQ(jobs[0], jobs[1]) << "what was offered is what was sliced";
  EXPECT_EQ(jobs[2], jobs[3]);
  EXPECT_NE(jobs[0], jobs[2]);
  EXPECT_EQ(rig.user.ids, (std::vector{jobs[0], jobs[2]})) << "the print's report has it";
  std::sort(questions.begin(), questions.end());
  EXPECT_EQ(std::adjacent_find(questions.begin(), questions.end()), questions.end());
  EXPECT_THAT(questions, Not(Contains(0U)));
}

TEST(Daemon, PrintsTenJobsInTheSameMemory) {
  DaemonRig rig;
  rig.put_scan("ball.ply", 1, 3000);
  rig.plant.plug_stick(rig.stick());
  std::vector<std::size_t> peaks;
  rig.user.on_printed = [&] {
    peaks.push_back(rig.arena.peak());
    EXPECT_EQ(rig.arena.used(), 0U);
    rig.arena.reset_peak();
    rig.plant.press(rig.user.reports.size() < 10 ? EventKind::kStartPressed : EventKind::kShutdownRequested);
  };
  rig.user.on_words.emplace("ready", [&] { rig.plant.press(EventKind::kStartPressed); });
  ASSERT_TRUE(rig.run());
  ASSERT_EQ(rig.user.reports.size(), 10U);
  for (const auto& hashes : rig.user.hashes) EXPECT_EQ(hashes, rig.user.hashes[0]);
  for (const auto peak : peaks) EXPECT_EQ(peak, peaks[0]);
}

}  // namespace
}  // namespace plumbline::firmware
