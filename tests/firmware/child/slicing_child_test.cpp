/// Real children: what they find, what they may do, and how they end.

#include "firmware/child/slicing_child.hpp"

#include <gmock/gmock.h>
#include <linux/filter.h>
#include <linux/landlock.h>
#include <linux/seccomp.h>
#include <signal.h>
#include <sys/prctl.h>
#include <sys/socket.h>
#include <sys/syscall.h>
#include <unistd.h>

#include <algorithm>
#include <cerrno>
#include <tuple>

#include "firmware/child/child_layer_decoder.hpp"
#include "firmware/settings/job_options.hpp"
#include "tests/firmware/child/child_fixture.hpp"
#include "tests/slicer/reader/formats/e57_file.hpp"
#include "tests/slicer/support/scan_cloud.hpp"
#include "tests/slicer/support/splat_files.hpp"

namespace plumbline::firmware {
namespace {

using ::testing::ElementsAreArray;
using ::testing::HasSubstr;

class SlicingChildTest : public ChildTest {};

TEST_F(SlicingChildTest, FindsWhatThisProcessFindsScanAfterScan) {
  auto child = make(2);
  for (const double radius : {8.0, 6.0, 7.0}) {
    const std::string path = folder_ / "ball.ply";
    write_sphere_scan(path, 6000, radius);
    const auto request = request_of(path, 2, true);
    ASSERT_EQ(run(child, request, path), 0);
    Arena arena(child.arena_block());
    const auto found = check_answer(child.answer(), request, arena);
    ASSERT_TRUE(found) << found.error().message();

    std::vector<std::byte> block(kArenaBytes);
    Arena here(block);
    const std::vector<std::string> paths{path};
    auto files = ScanFiles::open(paths);
    ASSERT_TRUE(files);
    SliceReport report;
    const auto expected = slice_for_print(files->sources(), request.settings, here, nullptr, report);
    ASSERT_TRUE(expected) << expected.error().message();
    const PrintGrid& grid = found->sliced.rrep.grid;
    EXPECT_EQ(std::tie(grid.columns, grid.rows, grid.layers),
              std::tie(expected->rrep.grid.columns, expected->rrep.grid.rows, expected->rrep.grid.layers));
    EXPECT_TRUE(std::ranges::equal(found->sliced.rrep.first, expected->rrep.first));
    EXPECT_TRUE(std::ranges::equal(found->sliced.rrep.packed, expected->rrep.packed));
    EXPECT_TRUE(std::ranges::equal(found->sliced.supports.list, expected->supports.list));
    EXPECT_FALSE(found->sliced.supports.empty()) << "a ball hangs over";
    EXPECT_EQ(found->sliced.scan_hash, expected->scan_hash);
    EXPECT_EQ(found->sliced.findings, expected->findings);
    EXPECT_GT(found->sliced.findings.first_layer_pixels, 0U);
  }
}

TEST_F(SlicingChildTest, ProposesTheBestWaysUpWithAPictureOfEach) {
  auto child = make(2);
  const std::string path = folder_ / "ball.ply";
  write_sphere_scan(path, 6000, 8);
  auto request = request_of(path, 2);
  request.proposes = true;
  request.settings.orient = true;
  request.settings.placement.size = PrintSize{Side::kHeight, 10};
  ASSERT_EQ(run(child, request, path), 0);
  const auto found = check_proposals(child.answer());
  ASSERT_TRUE(found) << found.error().message();
  EXPECT_EQ((*found)[0].degrees, (std::array<double, 2>{0, 0}));
  for (std::size_t i = 0; i < kProposalCount; ++i) {
    const Proposal& way = (*found)[i];
    EXPECT_NEAR(way.height_mm, 10, 0.5);
    EXPECT_NEAR(way.peel_mm2, 3.1416 * 25, 12) << "as patches show it";
    for (std::size_t k = 0; k < i; ++k) EXPECT_TRUE(k == 0 || way.degrees != (*found)[k].degrees);
    const ProposalPicture& picture = child.proposals()[i];
    ASSERT_TRUE(picture.there());
    // A ball whose box's diagonal fills the picture: the cap that needs supports is at its bottom, in orange.
    int orange = 0, pale = 0;
    for (std::size_t at = 0; at < picture.bytes().size(); at += 3) {
      const auto red = picture.bytes()[at], blue = picture.bytes()[at + 2];
      if (red > blue + 40) ++orange;
      if (red > 120 && red <= blue + 40) ++pale;
    }
    EXPECT_GT(orange, 200);
    EXPECT_GT(pale, 2000);
  }
  // What is no scan has none.
  const std::string broken = folder_ / "broken.ply";
  std::ofstream(broken) << "ply\n";
  auto of_broken = request_of(broken, 2);
  of_broken.proposes = true;
  ASSERT_EQ(run(child, of_broken, broken), 0);
  EXPECT_FALSE(check_proposals(child.answer()));
  EXPECT_FALSE(child.proposals()[0].there());
}

TEST_F(SlicingChildTest, DrawsAGlanceAtAScanFromTheSideThatWasScanned) {
  auto child = make(1);
  const std::string path = folder_ / "wall.ply";
  // A wall, 40 x 2 x 20, scanned from behind and from the right only: its left end and its front are missing.
  std::ofstream file(path);
  file << "ply\nformat ascii 1.0\nelement vertex 8400\n";
  for (const char* name : {"x", "y", "z", "nx", "ny", "nz"}) file << "property float " << name << "\n";
  file << "end_header\n";
  for (int i = 0; i < 8000; ++i) file << 0.4 * (i % 100) << " 2 " << 0.25 * (i / 100) << " 0 1 0\n";
  for (int i = 0; i < 400; ++i) file << "40 " << 0.4 * (i % 5) << ' ' << 0.25 * (i / 5) << " 1 0 0\n";
  file.close();
  auto request = request_of(path, 1);
  request.is_glance = true;
  ASSERT_EQ(run(child, request, path), 0);
  ASSERT_EQ(child.answer().kind, ScanAnswer::kGlance);
  const ScanPicture& picture = child.glance();
  ASSERT_TRUE(picture.there());
  // Its inside and the ground are darker, and bluish.
  int outside = 0;
  for (std::size_t at = 0; at < picture.bytes().size(); at += 3) {
    const int red = picture.bytes()[at], blue = picture.bytes()[at + 2];
    if (red > 130 && red >= blue) ++outside;
  }
  EXPECT_GT(outside, 500);
}

// Regression: libgomp waited for the threads of this process's team, which the child has not.
TEST_F(SlicingChildTest, StartsThreadsThoughThisProcessHasTeamsOfThem) {
  if (kHasSanitizer) GTEST_SKIP() << "a thread sanitizer allows no threads after such a fork";
  start_threads(4);
  const std::string path = folder_ / "ball.ply";
  write_sphere_scan(path, 3000, 4);
  for (const std::uint32_t threads : {1U, 2U, 4U, 6U}) {
    auto child = make(threads);
    EXPECT_EQ(run(child, request_of(path, threads), path), 0) << threads;
    EXPECT_EQ(child.answer().kind, ScanAnswer::kSliced) << threads;
  }
}

TEST_F(SlicingChildTest, SlicesSeveralFilesAsOneScanAndNamesTheBadOne) {
  const auto cloud = sphere_scan(6000, 4);
  std::vector<std::string> paths;
  ScanRequest request;
  request.name.add("part0.ply and 31 more");
  request.settings.placement.printer = small_printer();
  request.settings.placement.layer_height_mm = 0.1F;
  request.settings.threads = 1;
  std::vector<Descriptor> open;
  std::vector<int> descriptors;
  for (std::size_t i = 0; i < kMostScans; ++i) {
    paths.push_back(folder_ / ("part" + std::to_string(i) + ".ply"));
    const std::size_t from = cloud.size() * i / kMostScans, to = cloud.size() * (i + 1) / kMostScans;
    write_scan(paths.back(),
               {cloud.begin() + static_cast<std::ptrdiff_t>(from), cloud.begin() + static_cast<std::ptrdiff_t>(to)});
    request.add_file("part" + std::to_string(i) + ".ply", std::filesystem::file_size(paths.back()));
    open.emplace_back(::open(paths.back().c_str(), O_RDONLY | O_CLOEXEC));
    descriptors.push_back(open.back().get());
  }
  auto child = make(1);
  const auto finish = [&child] {
    std::optional<int> ended;
    while (!ended) ended = child.wait(std::chrono::seconds(1)).value();
    return *ended;
  };
  ASSERT_TRUE(child.start(request, descriptors));
  ASSERT_EQ(finish(), 0);
  Arena arena(child.arena_block());
  const auto found = check_answer(child.answer(), request, arena);
  ASSERT_TRUE(found) << found.error().message();
  auto files = ScanFiles::open(paths);
  ASSERT_TRUE(files);
  std::vector<std::byte> block(kArenaBytes);
  Arena here(block);
  SliceReport report;
  const auto expected = slice_for_print(files->sources(), request.settings, here, nullptr, report);
  ASSERT_TRUE(expected) << expected.error().message();
  EXPECT_TRUE(std::ranges::equal(found->sliced.rrep.first, expected->rrep.first));
  EXPECT_TRUE(std::ranges::equal(found->sliced.rrep.packed, expected->rrep.packed));
  EXPECT_EQ(found->sliced.scan_hash, expected->scan_hash);

  write_text(paths[7], read_text(paths[7]).substr(0, 300));
  for (const Descriptor& file : open) ::lseek(file.get(), 0, SEEK_SET);
  ASSERT_TRUE(child.start(request, descriptors));
  ASSERT_EQ(finish(), 0);
  Arena again(child.arena_block());
  const auto bad = check_answer(child.answer(), request, again);
  ASSERT_FALSE(bad);
  EXPECT_THAT(bad.error().message(), ::testing::StartsWith("part7.ply: "));
}

TEST_F(SlicingChildTest, ReportsErrorsOfTheScanInItsOwnWords) {
  auto child = make(1);
  const std::string path = folder_ / "cut.ply";
  write_text(path,
             "ply\nformat ascii 1.0\nelement vertex 5\nproperty float x\nproperty float y\nproperty float z\n"
             "end_header\n1 2 3\n");
  const auto request = request_of(path, 1);
  ASSERT_EQ(run(child, request, path), 0);
  Arena arena(child.arena_block());
  const auto found = check_answer(child.answer(), request, arena);
  ASSERT_FALSE(found);
  const std::vector<std::string> paths{path};
  auto files = ScanFiles::open(paths);
  std::vector<std::byte> block(kArenaBytes);
  Arena here(block);
  SliceReport report;
  const auto expected = slice_for_print(files->sources(), request.settings, here, nullptr, report);
  EXPECT_EQ(found.error().code(), expected.error().code());
  EXPECT_STREQ(found.error().message(), expected.error().message());
  EXPECT_EQ(found.error().advice(), expected.error().advice());
}

TEST_F(SlicingChildTest, IsToldApartFromABadMedium) {
  auto child = make(1);
  ScanRequest request;
  request.name.add("folder.ply");
  request.add_file("folder.ply", std::nullopt);
  request.settings.placement.printer = small_printer();
  ASSERT_EQ(run(child, request, folder_ / "."), 0) << "a folder can't be read, as a bad sector can't";
  Arena arena(child.arena_block());
  const auto found = check_answer(child.answer(), request, arena);
  ASSERT_FALSE(found);
  EXPECT_EQ(found.error().code(), ErrorCode::kCannotRead);
  EXPECT_THAT(std::string(found.error().advice()), HasSubstr("copy the file to another stick"));
}

/// Ends the process at the first request for memory.
void trap_memory_calls() {
  constexpr std::array kCalls = {
      SYS_brk,
      SYS_mremap,
#ifdef SYS_mmap
      SYS_mmap,
#endif
#ifdef SYS_mmap2
      SYS_mmap2,
#endif
  };
  std::vector<sock_filter> program{BPF_STMT(BPF_LD | BPF_W | BPF_ABS, offsetof(seccomp_data, nr))};
  for (const long call : kCalls) {
    program.push_back(BPF_JUMP(BPF_JMP | BPF_JEQ | BPF_K, static_cast<std::uint32_t>(call), 0, 1));
    program.push_back(BPF_STMT(BPF_RET | BPF_K, SECCOMP_RET_KILL_PROCESS));
  }
  program.push_back(BPF_STMT(BPF_RET | BPF_K, SECCOMP_RET_ALLOW));
  sock_fprog filter{};
  filter.len = static_cast<unsigned short>(program.size());
  filter.filter = program.data();
  if (::syscall(SYS_seccomp, SECCOMP_SET_MODE_FILTER, 0, &filter) != 0) ::_exit(77);
}

TEST_F(SlicingChildTest, TakesNoMemoryFromTheKernelNotEvenForItsThreads) {
  if (kHasSanitizer) GTEST_SKIP() << "a sanitizer takes memory";
  const std::string path = folder_ / "ball.ply";
  write_sphere_scan(path, 6000, 5);
  constexpr std::uint32_t kThreads = 4;
  auto child = make(kThreads, [](SharedMemory& memory, std::uint32_t threads) {
    trap_memory_calls();
    run_scan_task(memory, threads);
  });
  EXPECT_EQ(run(child, request_of(path, kThreads, true), path), 0);
  EXPECT_EQ(child.answer().kind, ScanAnswer::kSliced);

  // expat and zlib work in the arena, too.
  testing::E57TestScan scan;
  std::array<std::vector<double>, 3> metres;
  std::vector<testing::Splat> splats;
  for (const auto& p : testing::sphere(6000, 5, {0, 0, 0})) {
    for (std::size_t a = 0; a < 3; ++a) metres[a].push_back(p.position[static_cast<Eigen::Index>(a)] / 1000);
    splats.push_back({.position = p.position});
  }
  for (std::size_t a = 0; a < 3; ++a) {
    scan.columns.push_back(testing::double_column(std::string("cartesian") + static_cast<char>('X' + a), metres[a]));
  }
  scan.packet = 64 * 2000;
  const std::pair<const char*, std::string> files[] = {{"ball.e57", testing::E57File().bytes({scan})},
                                                       {"ball.spz", testing::gzip(testing::plain_spz(splats, 3))},
                                                       {"splats.ply", testing::splat_ply(splats)}};
  for (const auto& [name, bytes] : files) {
    write_text(folder_ / name, bytes);
    EXPECT_EQ(run(child, request_of(folder_ / name, kThreads), folder_ / name), 0) << name;
    EXPECT_EQ(child.answer().kind, ScanAnswer::kSliced) << name << child.answer().message.data();
  }
  auto control = make(1, [](SharedMemory&, std::uint32_t) {
    trap_memory_calls();
    ::syscall(SYS_brk, nullptr);
  });
  const int status = run(control, request_of(path, 1), path);
  EXPECT_TRUE(WIFSIGNALED(status) && WTERMSIG(status) == SIGSYS);
}

/// Writes what a process may do to its answer, before any filter.
void look_round(SharedMemory& memory, std::uint32_t /*threads*/) {
  FixedText<400> seen;
  for (int file = 1; file < 1024; ++file) {
    if (::fcntl(file, F_GETFD) >= 0) seen.add("has descriptor %d; ", file);
  }
  if (::open("/proc/self/status", O_RDONLY) >= 0) seen.add("opens a file; ");
  if (::open("/dev/null", O_RDWR) >= 0) seen.add("opens a device; ");
  if (::prctl(PR_CAPBSET_DROP, 21, 0, 0, 0) == 0) seen.add("has a capability; ");
  if (::prctl(PR_GET_NO_NEW_PRIVS, 0, 0, 0, 0) != 1) seen.add("may gain some; ");
  if (::prctl(PR_GET_DUMPABLE, 0, 0, 0, 0) != 0) seen.add("can be debugged; ");
  seen.view().copy(memory.page().answer.message.data(), 399);
}

TEST_F(SlicingChildTest, HasItsScanAndNoOtherFileDeviceOrCapability) {
  auto child = make(1, look_round);
  // Asked of the kernel: a child that leaves Landlock out must not pass this over.
  const long landlock = ::syscall(SYS_landlock_create_ruleset, nullptr, 0, LANDLOCK_CREATE_RULESET_VERSION);
  EXPECT_EQ(child.has_landlock(), landlock >= 1);
  if (landlock < 1) GTEST_SKIP() << "this kernel has no Landlock";
  const std::string path = folder_ / "any";
  write_text(path, "any");
  EXPECT_EQ(run(child, request_of(path, 1), path), 0);
  EXPECT_STREQ(child.answer().message.data(), "");
}

/// What a child might try; the request's name says which.
void attempt(SharedMemory& memory, std::uint32_t threads) {
  start_threads(threads);
  if (!filter_system_calls()) ::_exit(77);
  const auto what = memory.page().request.name.view();
  if (what == "open") static_cast<void>(::open("/etc/passwd", O_RDONLY));
  if (what == "socket") static_cast<void>(::socket(AF_UNIX, SOCK_STREAM, 0));
  if (what == "kill") static_cast<void>(::kill(::getppid(), 0));
  if (what == "fork") static_cast<void>(::fork());
  if (what == "exec") static_cast<void>(::execl("/bin/true", "true", nullptr));
  if (what == "ptrace") static_cast<void>(::syscall(SYS_ptrace, 16, 1, 0, 0));
  if (what == "another's memory") static_cast<void>(::syscall(SYS_process_vm_writev, 1, nullptr, 0, nullptr, 0, 0));
  if (what == "executable memory") static_cast<void>(::syscall(SYS_mprotect, memory.arena().data(), 4096, 7));
  if (what == "ioctl") static_cast<void>(::syscall(SYS_ioctl, 0, 0, 0));
  if (what == "priority") static_cast<void>(::syscall(SYS_setpriority, 0, 0, 0));
  if (what == "write") {
    memory.page().answer.code = static_cast<std::uint32_t>(::syscall(SYS_write, 0, "", 0) == -1 ? errno : 0);
  }
  if (what == "memory") {
    memory.page().answer.code = static_cast<std::uint32_t>(::syscall(SYS_mremap, 0, 0, 0, 0) == -1 ? errno : 0);
  }
}

TEST_F(SlicingChildTest, IsEndedWhenItTriesAnythingButReading) {
  if (kHasSanitizer) GTEST_SKIP() << "system calls are not filtered";
  auto child = make(2, attempt);
  const std::string path = folder_ / "any";
  write_text(path, "any");
  auto request = request_of(path, 2);
  const auto status_of = [&](const char* what) {
    request.name.clear();
    request.name.add("%s", what);
    return run(child, request, path);
  };
  for (const char* what : {"open", "socket", "kill", "fork", "exec", "ptrace", "another's memory", "executable memory",
                           "ioctl", "priority"}) {
    const int status = status_of(what);
    EXPECT_TRUE(WIFSIGNALED(status) && WTERMSIG(status) == SIGSYS) << what << ": " << status;
  }
  EXPECT_EQ(status_of("nothing"), 0);
  EXPECT_EQ(status_of("write"), 0) << "abort() tries that";
  EXPECT_EQ(child.answer().code, static_cast<std::uint32_t>(EPERM));
  EXPECT_EQ(status_of("memory"), 0) << "the C library handles that";
  EXPECT_EQ(child.answer().code, static_cast<std::uint32_t>(ENOMEM));
}

TEST_F(SlicingChildTest, CanBeKilledAndTheNextOneWorks) {
  const std::string path = folder_ / "ball.ply";
  write_sphere_scan(path, 3000, 4);
  auto child = make(2, [](SharedMemory& memory, std::uint32_t threads) {
    while (memory.page().request.name.view() == "hangs") {
    }
    run_scan_task(memory, threads);
  });
  auto request = request_of(path, 2);
  request.name.clear();
  request.name.add("hangs");
  const Descriptor scan(::open(path.c_str(), O_RDONLY | O_CLOEXEC));
  for (int times = 0; times < 20; ++times) {
    ASSERT_TRUE(child.start(request, scan.get()));
    EXPECT_FALSE(*child.wait(std::chrono::milliseconds(1)));
    child.kill();
    std::optional<int> ended;
    while (!ended) ended = child.wait(std::chrono::seconds(1)).value();
    EXPECT_TRUE(WIFSIGNALED(*ended) && WTERMSIG(*ended) == SIGKILL);
    child.kill();  // too late, which does no harm
  }
  EXPECT_EQ(run(child, request_of(path, 2), path), 0);
  EXPECT_EQ(child.answer().kind, ScanAnswer::kSliced);
}

TEST_F(SlicingChildTest, CanNotBeStartedWithoutItsTemplateAndEndsWithIt) {
  auto child = make(1, [](SharedMemory& memory, std::uint32_t) {
    for (;;) ++memory.page().progress.beats;
  });
  const std::string path = folder_ / "any";
  write_text(path, "any");
  const Descriptor scan(::open(path.c_str(), O_RDONLY | O_CLOEXEC));
  ASSERT_TRUE(child.start(request_of(path, 1), scan.get()));
  while (child.progress().beats == 0) {
  }
  ASSERT_EQ(::kill(child.template_process(), SIGKILL), 0);
  auto ended = child.wait(std::chrono::seconds(10));
  ASSERT_FALSE(ended);
  EXPECT_EQ(ended.error().code(), ErrorCode::kDeviceTimeout);
  EXPECT_TRUE(child.gone());
  EXPECT_FALSE(child.start(request_of(path, 1), scan.get()));
  // The child dies with the template: it stops counting.
  std::uint32_t before = 0;
  do {
    before = child.progress().beats;
    ::usleep(20'000);
  } while (child.progress().beats != before);
}

/// A template that is stopped takes no messages and reports nothing.
class StoppedTemplate : public SlicingChildTest {
 protected:
  static std::chrono::milliseconds since(std::chrono::steady_clock::time_point begin) {
    return std::chrono::duration_cast<std::chrono::milliseconds>(std::chrono::steady_clock::now() - begin);
  }
  static SlicingChild make_counting() {
    return make(1, [](SharedMemory& memory, std::uint32_t) {
      for (;;) ++memory.page().progress.beats;
    });
  }
};

TEST_F(StoppedTemplate, IsKilledWithItsChildWhenItDoesNotReportTheEnd) {
  auto child = make_counting();
  const std::string path = folder_ / "any";
  write_text(path, "any");
  const Descriptor scan(::open(path.c_str(), O_RDONLY | O_CLOEXEC));
  ASSERT_TRUE(child.start(request_of(path, 1), scan.get()));
  while (child.progress().beats == 0) {
  }
  const pid_t process = child.template_process();
  ASSERT_EQ(::kill(process, SIGSTOP), 0);
  const auto began = std::chrono::steady_clock::now();
  EXPECT_FALSE(*child.wait(std::chrono::milliseconds(50))) << "nobody has killed the child";
  child.kill(std::chrono::milliseconds(200));
  child.kill();  // does not prolong it
  EXPECT_FALSE(*child.wait(std::chrono::milliseconds(20)));
  const auto ended = child.wait(std::chrono::seconds(60));
  EXPECT_LT(since(began), std::chrono::seconds(5));
  ASSERT_FALSE(ended);
  EXPECT_EQ(ended.error().code(), ErrorCode::kDeviceTimeout);
  EXPECT_TRUE(child.gone());
  EXPECT_NE(::kill(process, 0), 0) << "it is reaped";
  const std::uint32_t before = child.progress().beats;
  ::usleep(50'000);
  EXPECT_EQ(child.progress().beats, before) << "nothing writes to the memory any more";
  EXPECT_FALSE(child.start(request_of(path, 1), scan.get()));
  EXPECT_FALSE(child.wait(std::chrono::seconds(60)));
}

TEST_F(StoppedTemplate, TakesNobodyWhoSendsItMessages) {
  auto child = make_counting();
  const std::string path = folder_ / "any";
  write_text(path, "any");
  const Descriptor scan(::open(path.c_str(), O_RDONLY | O_CLOEXEC));
  ASSERT_EQ(::kill(child.template_process(), SIGSTOP), 0);
  const auto began = std::chrono::steady_clock::now();
  bool all = true;
  for (int times = 0; times < 5000 && all; ++times) all = child.start(request_of(path, 1), scan.get()).has_value();
  EXPECT_FALSE(all) << "the socket is full";
  EXPECT_LT(since(began), std::chrono::seconds(5));
}

TEST_F(StoppedTemplate, IsEndedWithItsOwner) {
  const auto began = std::chrono::steady_clock::now();
  pid_t process = -1;
  {
    const auto child = make_counting();
    process = child.template_process();
    ASSERT_EQ(::kill(process, SIGSTOP), 0);
  }
  EXPECT_NE(::kill(process, 0), 0);
  EXPECT_LT(since(began), std::chrono::seconds(6));
}

// Regression: the print waited for ever, and the daemon heard no request to end.
TEST_F(StoppedTemplate, EndsTheDecodingOfALayer) {
  auto child = make_counting();
  const std::string path = folder_ / "any";
  write_text(path, "any");
  const Descriptor archive(::open(path.c_str(), O_RDONLY | O_CLOEXEC));
  using namespace std::chrono_literals;
  ChildLayerDecoder decoder(child, small_printer(), {.layer = 200ms, .last = 100ms, .end = 300ms});
  Arena arena(child.arena_block());
  PrintGrid grid;
  grid.columns = small_printer().columns;
  grid.rows = small_printer().rows;
  ASSERT_TRUE(decoder.prepare(grid, false, arena));
  std::vector<std::uint64_t> words(BitImage::words_needed(grid.columns, grid.rows));
  ASSERT_EQ(::kill(child.template_process(), SIGSTOP), 0);
  const auto began = std::chrono::steady_clock::now();
  GreyRuns greys;
  const auto decoded = decoder.decode(archive.get(), "any", {}, {}, BitImage(words, grid.columns, grid.rows), greys);
  EXPECT_LT(since(began), 5s);
  ASSERT_FALSE(decoded);
  EXPECT_EQ(decoded.error().code(), ErrorCode::kDeviceTimeout) << "no fault of the archive";
}

}  // namespace
}  // namespace plumbline::firmware
