/// Once admitted, a job takes nothing from the heap.

#include "tests/firmware/support/heap_trap.hpp"

#include <gtest/gtest.h>
#include <omp.h>

#include <cstdio>
#include <cstdlib>

#include "firmware/io/progress_lines.hpp"
#include "firmware/pictures/preview/preview.hpp"
#include "firmware/slice/job_summary.hpp"
#include "tests/firmware/support/job_fixture.hpp"

namespace plumbline::firmware {
namespace {

alignas(64) std::byte arena_block[std::size_t{64} * 1024 * 1024];

/// Hides a block from the compiler, so that it can't remove the allocation.
void* escaped(void* block) {
  static void* volatile anybody_may_look;
  anybody_may_look = block;
  return anybody_may_look;
}

TEST(HeapTrap, CountsAllocationsOfCAndCpp) {
  HeapTrap trap;
  void* const kept[] = {escaped(std::malloc(10)), escaped(::operator new(10)), escaped(std::calloc(1, 10)),
                        escaped(std::aligned_alloc(64, 64))};
  const int found = trap.disarm().trapped;
  std::free(kept[0]);
  ::operator delete(kept[1]);
  std::free(kept[2]);
  std::free(kept[3]);
  EXPECT_EQ(found, 4);
}

TEST(HeapTrap, CountsAllocationsOfOtherThreads) {
  omp_set_dynamic(0);
  const auto take = [] {
#pragma omp parallel num_threads(2)
    std::free(escaped(std::malloc(10)));
  };
  take();  // the first region makes the threads
  HeapTrap trap;
  take();
  const HeapUse use = trap.disarm();
  EXPECT_EQ(use.trapped, 2);
}

TEST(HeapTrap, CountsBuffersOfStandardFiles) {
  HeapTrap trap;
  std::FILE* file = std::fopen("/dev/null", "w");
  const HeapUse use = trap.disarm();
  ASSERT_NE(file, nullptr);
  std::fclose(file);
  EXPECT_GE(use.trapped, 1);
}

TEST(Job, TakesNothingFromTheHeapAfterItsAdmission) {
  const TemporaryFolder folder;
  write_sphere_scan(folder / "sphere.ply", 60'000, 12);
  Arena arena(arena_block);
  auto settings = sphere_job(folder);
  settings.slice.supports = SupportSettings{};
  auto job = SliceJob::prepare(settings, arena);
  ASSERT_TRUE(job.has_value()) << job.error().message();
  ProgressLines lines;
  JobProgress progress(&lines);
  auto summary = OutputFile::create("/dev/null");
  ASSERT_TRUE(summary.has_value());

  HeapTrap trap;
  const auto done = job->run(progress);
  const auto told = write_summary(*summary, job->report(), "out", "", true);
  const HeapUse use = trap.disarm();

  ASSERT_TRUE(done.has_value()) << done.error().message();
  EXPECT_TRUE(told.has_value());
  EXPECT_TRUE(job->report().has_preview);
  EXPECT_GT(job->report().supports.all(), 0U);
  EXPECT_EQ(use.trapped, 0);
  if (use.trapped > 0) HeapTrap::print_stacks();
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
  const HeapUse use = trap.disarm();
  ASSERT_TRUE(done.has_value()) << done.error().message();
  EXPECT_EQ(job->report().slice.normals.estimated, 20'000U);
  EXPECT_EQ(use.trapped, 0);
  if (use.trapped > 0) HeapTrap::print_stacks();
}

TEST(Job, TakesNothingFromTheHeapWhenItFails) {
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
  const HeapUse use = trap.disarm();
  ASSERT_FALSE(done.has_value());
  EXPECT_EQ(done.error().code(), ErrorCode::kDoesNotFit);
  EXPECT_EQ(use.trapped, 0);
  if (use.trapped > 0) HeapTrap::print_stacks();
}

}  // namespace
}  // namespace plumbline::firmware
