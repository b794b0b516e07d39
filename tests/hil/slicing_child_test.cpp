/// The daemon with children that crash, hang and scribble: it says so and prints the next stick.

#include <gmock/gmock.h>
#include <gtest/gtest.h>
#include <signal.h>
#include <sys/time.h>

#include <csignal>
#include <random>

#include "tests/hil/session_rig.hpp"

namespace plumbline::firmware {
namespace {

using namespace std::chrono_literals;
using ::testing::AnyOf;
using ::testing::Contains;
using ::testing::HasSubstr;
using ::testing::StartsWith;

// A scan's name says what its child does at a random moment of its work: "crash-7.ply". The number is the seed.
SharedMemory* child_memory =
    nullptr;                // NOLINT(cppcoreguidelines-avoid-non-const-global-variables): for a signal handler
std::mt19937 child_random;  // NOLINT(cppcoreguidelines-avoid-non-const-global-variables)

void crash(int /*signal*/) { *static_cast<volatile int*>(nullptr) = 1; }
void hang(int /*signal*/) {
  for (;;) {
  }
}
void scribble(int /*signal*/) {
  MessagePage& page = child_memory->page();
  const auto at_random = [](std::span<std::byte> bytes) {
    const auto times = 1 + child_random() % 2000;
    for (std::size_t i = 0; i < times; ++i)
      bytes[child_random() % bytes.size()] = static_cast<std::byte>(child_random());
  };
  at_random(std::as_writable_bytes(std::span(&page.progress, 1)));
  if (child_random() % 2 == 0) at_random(std::as_writable_bytes(std::span(&page.answer, 1)));
  if (child_random() % 2 == 0) at_random(std::as_writable_bytes(std::span(&page.request, 1)));
  at_random(child_memory->arena().first(child_memory->arena().size() >> (child_random() % 8)));
}

void misbehave(SharedMemory& memory, std::uint32_t threads) {
  const std::string name(memory.page().request.name.view());
  child_memory = &memory;
  const auto dash = name.find('-');
  auto* const deed = name.starts_with("crash") ? crash : name.starts_with("hang") ? hang : scribble;
  if (dash != std::string::npos) {
    child_random.seed(static_cast<std::uint32_t>(std::stoul(name.substr(dash + 1))));
    ::signal(SIGALRM, deed);
    itimerval when{};
    when.it_value.tv_usec = 1 + static_cast<long>(child_random() % 60'000);  // a scan of this test takes some 30 ms
    if (name.starts_with("scribble")) when.it_interval.tv_usec = 5000;
    ::setitimer(ITIMER_REAL, &when, nullptr);
  }
  run_stick_task(memory, threads);
  if (dash != std::string::npos) deed(0);  // some of them after its answer
}

std::vector<std::uint64_t> undisturbed_masks() {
  DaemonRig rig;
  rig.put_scan("good.ply");
  rig.plant.plug_stick(rig.stick());
  rig.user.on_printed = [&] { rig.plant.press(EventKind::kShutdownRequested); };
  EXPECT_TRUE(rig.run());
  return rig.user.hashes.at(0);
}

/// A pipe to a child that has ended is an error, no end of this program: catch_interrupts() does the same.
class SlicingChildren : public testing::Test {
 protected:
  void SetUp() override { std::signal(SIGPIPE, SIG_IGN); }
};

TEST_F(SlicingChildren, ThatCrashHangOrScribbleAreErrorsOfTheirScanAndTheNextStickPrints) {
  const auto expected = undisturbed_masks();
  DaemonRig rig(session_plant(), std::size_t{24} << 20U, misbehave);
  rig.patience = 200ms;
  constexpr int kSticks = 30;
  int stick = 0;
  std::string name;
  const auto next_stick = [&] {
    rig.plant.pull_stick();
    if (!name.empty()) std::filesystem::remove(rig.stick() + "/" + name);
    EXPECT_EQ(rig.arena.used(), 0U) << name;
    if (stick == kSticks) return rig.plant.press(EventKind::kShutdownRequested);
    constexpr std::array<const char*, 3> kKinds = {"crash", "hang", "scribble"};
    name = std::string(kKinds[static_cast<std::size_t>(stick % 3)]) + "-" + std::to_string(stick) + ".ply";
    ++stick;
    rig.put_scan(name);
    rig.plant.plug_stick(rig.stick());
  };
  next_stick();
  rig.user.on_words.emplace("PL-1", next_stick);
  rig.user.on_printed = next_stick;  // a scribble may hit nothing that matters
  // Once the next stick is in, too, since a press in the second after it counts for nothing.
  rig.user.on_words.emplace("is the plate empty?", [&] {
    rig.plant.timeline().at(rig.plant.now() + 2s, [&] { rig.plant.press(EventKind::kStartPressed); });
  });
  ASSERT_TRUE(rig.run());
  EXPECT_EQ(stick, kSticks);
  rig.patience = kSlicingPatience;
  rig.put_scan("good.ply");
  rig.plant.plug_stick(rig.stick());
  // The last fault is shown again until somebody has seen it.
  rig.user.on_words.clear();
  rig.user.on_words.emplace("PL-1", [&] {
    rig.plant.timeline().at(rig.plant.now() + 2s, [&] { rig.plant.press(EventKind::kStartPressed); });
  });
  rig.user.on_printed = [&] { rig.plant.press(EventKind::kShutdownRequested); };
  ASSERT_TRUE(rig.run());
  ASSERT_FALSE(rig.user.hashes.empty());
  EXPECT_EQ(rig.user.hashes.back(), expected) << "the same print as ever";
  std::map<std::string, int> codes;
  for (const auto& text : rig.user.said) {
    if (text.starts_with("PL-")) ++codes[text.substr(0, 6)];
  }
  EXPECT_GE(codes["PL-102"], kSticks / 2) << "most are caught in their work";
  for (const auto& [code, times] : codes) EXPECT_THAT(code, StartsWith("PL-10")) << times;
  EXPECT_THAT(rig.user.said, Contains(AllOf(HasSubstr("crash-"), HasSubstr("(signal 11)"))));
  EXPECT_THAT(rig.user.said, Contains(AllOf(HasSubstr("hang-"), HasSubstr("no progress"))));
}

TEST_F(SlicingChildren, ThatOnlySeemToWorkAreEnded) {
  DaemonRig rig(session_plant(), std::size_t{24} << 20U, [](SharedMemory& memory, std::uint32_t) {
    for (;;) ++memory.page().progress.beats;
  });
  rig.patience = 30ms;
  rig.put_scan("ball.ply");
  rig.plant.plug_stick(rig.stick());
  rig.user.on_words.emplace("PL-102", [&] { rig.plant.press(EventKind::kShutdownRequested); });
  ASSERT_TRUE(rig.run());
  EXPECT_THAT(rig.user.said, Contains(HasSubstr("ball.ply: reading it made no progress")));
}

TEST_F(SlicingChildren, EndWhenCancelIsPressed) {
  DaemonRig rig(session_plant(), std::size_t{24} << 20U, [](SharedMemory&, std::uint32_t) { hang(0); });
  rig.put_scan("ball.ply");
  rig.plant.plug_stick(rig.stick());
  rig.user.on_slicing = [&] { rig.plant.press(EventKind::kCancelPressed); };
  rig.user.on_words.emplace("cancelled", [&] { rig.plant.press(EventKind::kShutdownRequested); });
  ASSERT_TRUE(rig.run());
  EXPECT_TRUE(rig.user.reports.empty());
}

/// A name says what the child does about a picture of it.
void misbehave_at_a_glance(SharedMemory& memory, std::uint32_t threads) {
  MessagePage& page = memory.page();
  const std::string name(page.request.name.view());
  const bool looks = page.request.is_glance || page.request.archive.ask == ArchiveRequest::Ask::kGlance;
  const auto does = [&](const char* deed) { return looks && name.find(deed) != std::string::npos; };
  if (does("crashes")) __builtin_trap();
  if (does("hangs")) hang(0);
  run_stick_task(memory, threads);
  if (does("says larger")) page.glance.columns = page.glance.rows = UINT32_MAX;
  if (does("says longer")) page.glance.rows = ScanPicture::kMostRows + 1;
  if (does("says nothing")) page.glance.clear();
  if (does("says other")) page.answer.kind = ScanAnswer::kSliced;
  if (does("breaks")) __builtin_trap();
}

TEST_F(SlicingChildren, ThatFailAtAGlanceCostOnlyThePictureOfTheirFile) {
  DaemonRig rig(session_plant(), std::size_t{24} << 20U, misbehave_at_a_glance);
  rig.start = StartChoice::kOnRequest;
  rig.patience = 600ms;
  const std::vector<std::string> bad = {"1 crashes.ply",     "2 hangs.ply",        "3 says larger.ply",
                                        "4 says longer.ply", "5 says nothing.ply", "6 says other.ply",
                                        "7 breaks.ply",      "8 crashes.sl1",      "9 hangs.sl1"};
  const auto after = [](const std::string& name) { return name.substr(0, 1) + " then a good one.ply"; };
  for (const std::string& name : bad) {
    rig.put_scan(name);
    rig.put_scan(after(name));
  }
  rig.plant.plug_stick(rig.stick());
  const auto has_picture = [&](const std::string& name) {
    return std::ranges::any_of(rig.record.scans,
                               [&](const ScanRecord& scan) { return scan.name.view() == name && scan.picture > 0; });
  };
  const auto end = std::chrono::steady_clock::now() + 60s;
  rig.user.on_idle = [&] {
    const bool all = std::ranges::all_of(bad, [&](const auto& name) { return has_picture(after(name)); });
    rig.user.idle_turns = 0;  // a child takes this machine's time, not the printer's
    if (all || std::chrono::steady_clock::now() > end) rig.plant.press(EventKind::kShutdownRequested);
  };
  ASSERT_TRUE(rig.run());
  EXPECT_EQ(rig.record.scan_count, 2 * bad.size() + 1) << "the good ones may be parts of one";
  for (const std::string& name : bad) {
    EXPECT_FALSE(has_picture(name)) << name;
    EXPECT_TRUE(has_picture(after(name))) << name;
  }
  EXPECT_TRUE(rig.user.reports.empty());
}

TEST_F(SlicingChildren, ThatLookAtAScanMakeWayForAPrint) {
  const auto expected = undisturbed_masks();
  DaemonRig rig(session_plant(), std::size_t{24} << 20U, misbehave_at_a_glance);
  rig.start = StartChoice::kOnRequest;
  rig.put_scan("hangs.ply");
  rig.plant.plug_stick(rig.stick());
  rig.user.on_words.emplace("Press start to print it", [&] { rig.plant.press(EventKind::kStartPressed); });
  rig.user.on_printed = [&] { rig.plant.press(EventKind::kShutdownRequested); };
  ASSERT_TRUE(rig.run());
  ASSERT_EQ(rig.user.hashes.size(), 1U);
  EXPECT_EQ(rig.user.hashes[0], expected);
}

TEST_F(SlicingChildren, ThatCanNotBeStartedAnyMoreEndTheDaemonWithWords) {
  DaemonRig rig;
  rig.put_scan("ball.ply");
  ::kill(rig.child.template_process(), SIGKILL);
  rig.plant.plug_stick(rig.stick());
  const auto served = rig.run();
  ASSERT_FALSE(served);
  EXPECT_EQ(served.error().code(), ErrorCode::kDeviceTimeout);
  EXPECT_THAT(served.error().message(), HasSubstr("scans can't be read any more"));
}

}  // namespace
}  // namespace plumbline::firmware
