/// After a job has been admitted nothing takes memory from the heap but lodepng, and lodepng only for the image at hand.
///
/// This program has its own malloc and its relatives, in front of those of the C library: whoever is linked into it, statically
/// or not, calls these. A call is lodepng's when code of lodepng's shared library is on the stack.

#include <dlfcn.h>
#include <execinfo.h>
#include <gtest/gtest.h>
#include <malloc.h>
#include <omp.h>
#include <unistd.h>

#include <algorithm>
#include <array>
#include <atomic>
#include <cerrno>
#include <cstddef>
#include <cstdio>
#include <cstdlib>
#include <cstring>

#include "firmware/job_summary.hpp"
#include "firmware/preview.hpp"
#include "firmware/progress_lines.hpp"
#include "tests/firmware/job_fixture.hpp"

// What is replaced below, under the names that the C library keeps for itself.
extern "C" {
void* real_malloc(std::size_t size) asm("__libc_malloc");
void* real_calloc(std::size_t count, std::size_t size) asm("__libc_calloc");
void* real_realloc(void* block, std::size_t size) asm("__libc_realloc");
void* real_memalign(std::size_t align, std::size_t size) asm("__libc_memalign");
void real_free(void* block) asm("__libc_free");
}

namespace {

// Plain static objects without constructors: malloc is called before main, and in every thread.
constexpr int kFrames = 24;
constexpr int kMostStacks = 4;
std::atomic<bool> armed{false};
std::atomic<int> trapped{0};
std::atomic<int> from_lodepng{0};
void* stacks[kMostStacks][kFrames];
int stack_sizes[kMostStacks];
thread_local bool in_trap = false;

/// Blocks that lodepng took and nobody has freed yet.
constexpr std::size_t kMostBlocks = 256;
void* lodepng_blocks[kMostBlocks];
std::size_t lodepng_live = 0;
std::size_t lodepng_peak = 0;
bool lodepng_overflow = false;

bool has_lodepng(void* const* stack, int frames) {
  for (int i = 0; i < frames; ++i) {
    Dl_info info = {};
    if (dladdr(stack[i], &info) != 0 && info.dli_fname != nullptr &&
        std::strstr(info.dli_fname, "liblodepng") != nullptr) {
      return true;
    }
  }
  return false;
}

void record_lodepng(void* block) {
  ++from_lodepng;
  for (void*& slot : lodepng_blocks) {
    if (slot != nullptr) continue;
    slot = block;
    lodepng_live += malloc_usable_size(block);
    lodepng_peak = std::max(lodepng_peak, lodepng_live);
    return;
  }
  lodepng_overflow = true;
}

void forget_lodepng(void* block) {
  for (void*& slot : lodepng_blocks) {
    if (slot != block) continue;
    slot = nullptr;
    lodepng_live -= malloc_usable_size(block);
    return;
  }
}

void* seen(void* block) {
  if (!armed.load(std::memory_order_relaxed) || in_trap || block == nullptr) return block;
  in_trap = true;
  void* stack[kFrames];
  const int frames = backtrace(stack, kFrames);
  if (has_lodepng(stack, frames)) {
    record_lodepng(block);
  } else {
    const int n = trapped.fetch_add(1);
    if (n < kMostStacks) {
      std::copy_n(stack, frames, stacks[n]);
      stack_sizes[n] = frames;
    }
  }
  in_trap = false;
  return block;
}

void leaves(void* block) {
  if (block != nullptr && armed.load(std::memory_order_relaxed)) forget_lodepng(block);
}

/// Traps from construction to destruction.
class HeapTrap {
 public:
  HeapTrap() {
    void* warm[kFrames];
    backtrace(warm, kFrames);  // its first call loads a library, which takes memory
    trapped = 0;
    from_lodepng = 0;
    lodepng_live = 0;
    lodepng_peak = 0;
    armed = true;
  }
  ~HeapTrap() { disarm(); }
  HeapTrap(const HeapTrap&) = delete;
  HeapTrap& operator=(const HeapTrap&) = delete;
  void disarm() { armed = false; }
  static void print_stacks() {
    for (int i = 0; i < std::min(trapped.load(), kMostStacks); ++i) {
      backtrace_symbols_fd(stacks[i], stack_sizes[i], STDERR_FILENO);
      static_cast<void>(!write(STDERR_FILENO, "\n", 1));
    }
  }
};

}  // namespace

// Under the names of what they replace: the linker sees those, the compiler and its knowledge of malloc do not.
extern "C" {
void* trapped_malloc(std::size_t size) asm("malloc");
void* trapped_calloc(std::size_t count, std::size_t size) asm("calloc");
void* trapped_realloc(void* block, std::size_t size) asm("realloc");
void trapped_free(void* block) asm("free");
void* trapped_memalign(std::size_t align, std::size_t size) asm("memalign");
void* trapped_aligned_alloc(std::size_t align, std::size_t size) asm("aligned_alloc");
int trapped_posix_memalign(void** block, std::size_t align, std::size_t size) asm("posix_memalign");

void* trapped_malloc(std::size_t size) { return seen(real_malloc(size)); }
void* trapped_calloc(std::size_t count, std::size_t size) { return seen(real_calloc(count, size)); }
void* trapped_realloc(void* block, std::size_t size) {
  leaves(block);
  return seen(real_realloc(block, size));
}
void trapped_free(void* block) {
  leaves(block);
  real_free(block);
}
void* trapped_memalign(std::size_t align, std::size_t size) { return seen(real_memalign(align, size)); }
void* trapped_aligned_alloc(std::size_t align, std::size_t size) { return seen(real_memalign(align, size)); }
int trapped_posix_memalign(void** block, std::size_t align, std::size_t size) {
  *block = seen(real_memalign(align, size));
  return *block == nullptr ? ENOMEM : 0;
}
}

namespace plumbline {
namespace {

alignas(64) std::byte arena_block[std::size_t{64} * 1024 * 1024];

/// Hides from the compiler where a block goes, so that it cannot leave out taking it.
void* escaped(void* block) {
  static void* volatile anybody_may_look;
  anybody_may_look = block;
  return anybody_may_look;
}

TEST(HeapTrap, SeesWhatTheCLibraryAndTheLanguageTake) {
  HeapTrap trap;
  void* const kept[] = {escaped(std::malloc(10)), escaped(::operator new(10)), escaped(std::calloc(1, 10)),
                        escaped(std::aligned_alloc(64, 64))};
  trap.disarm();
  const int found = trapped;
  std::free(kept[0]);
  ::operator delete(kept[1]);
  std::free(kept[2]);
  std::free(kept[3]);
  EXPECT_EQ(found, 4);
}

TEST(HeapTrap, SeesWhatOtherThreadsTake) {
  omp_set_dynamic(0);
  const auto take = [] {
#pragma omp parallel num_threads(2)
    std::free(escaped(std::malloc(10)));
  };
  take();  // the first region makes the threads
  HeapTrap trap;
  take();
  trap.disarm();
  EXPECT_EQ(trapped, 2);
}

TEST(HeapTrap, SeesTheBuffersOfStandardFiles) {
  HeapTrap trap;
  std::FILE* file = std::fopen("/dev/null", "w");
  trap.disarm();
  ASSERT_NE(file, nullptr);
  std::fclose(file);
  EXPECT_GE(trapped, 1);
}

TEST(Job, TakesNothingFromTheHeapAfterItsAdmissionButWhatLodepngReturns) {
  const TemporaryFolder folder;
  write_sphere_scan(folder / "sphere.ply", 60'000, 12);
  Arena arena(arena_block);
  auto settings = sphere_job(folder);
  settings.supports = SupportSettings{};
  auto job = SliceJob::prepare(settings, arena);
  ASSERT_TRUE(job.has_value()) << job.error().message();
  ProgressLines lines;
  JobProgress progress(&lines);
  auto summary = OutputFile::create("/dev/null");
  ASSERT_TRUE(summary.has_value());

  HeapTrap trap;
  const auto done = job->run(progress);
  const auto told = write_summary(*summary, job->report(), "out");
  trap.disarm();

  ASSERT_TRUE(done.has_value()) << done.error().message();
  EXPECT_TRUE(told.has_value());
  EXPECT_TRUE(job->report().has_preview);
  EXPECT_GT(job->report().supports.all(), 0U);
  EXPECT_EQ(trapped, 0);
  if (trapped > 0) HeapTrap::print_stacks();

  // The control that the masks and the preview did go through lodepng.
  EXPECT_GE(from_lodepng, static_cast<int>(job->report().slice.placement.grid.layers));
  EXPECT_FALSE(lodepng_overflow);
  EXPECT_EQ(lodepng_live, 0U) << "bytes of lodepng that nobody has freed";
  // The largest image is the preview; lodepng holds it filtered, compressed, and as a file.
  constexpr std::size_t kPreviewBytes = std::size_t{3} * kPreviewColumns * kPreviewRows;
  EXPECT_LE(lodepng_peak, 3 * kPreviewBytes);
}

TEST(Job, TakesNothingFromTheHeapWhenItEstimatesNormals) {
  const TemporaryFolder folder;
  write_sphere_scan(folder / "sphere.ply", 20'000, 12, false);
  Arena arena(arena_block);
  auto settings = sphere_job(folder);
  settings.preview = false;
  auto job = SliceJob::prepare(settings, arena);
  ASSERT_TRUE(job.has_value()) << job.error().message();
  JobProgress progress(nullptr);
  HeapTrap trap;
  const auto done = job->run(progress);
  trap.disarm();
  ASSERT_TRUE(done.has_value()) << done.error().message();
  EXPECT_EQ(job->report().slice.normals_estimated, 20'000U);
  EXPECT_EQ(trapped, 0);
  if (trapped > 0) HeapTrap::print_stacks();
}

TEST(Job, TakesNothingFromTheHeapOnAnErrorsWayOut) {
  const TemporaryFolder folder;
  write_sphere_scan(folder / "sphere.ply", 20'000, 12);
  Arena arena(arena_block);
  auto settings = sphere_job(folder);
  settings.slice.placement.scale = 4;
  auto job = SliceJob::prepare(settings, arena);
  ASSERT_TRUE(job.has_value()) << job.error().message();
  JobProgress progress(nullptr);
  HeapTrap trap;
  const auto done = job->run(progress);
  trap.disarm();
  ASSERT_FALSE(done.has_value());
  EXPECT_EQ(done.error().code(), ErrorCode::kDoesNotFit);
  EXPECT_EQ(trapped, 0);
  if (trapped > 0) HeapTrap::print_stacks();
}

}  // namespace
}  // namespace plumbline
