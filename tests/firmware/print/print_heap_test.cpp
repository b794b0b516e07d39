/// A whole print, from the scan's first byte to the last layer, doesn't use the heap. Only the simulated machine may.

#include <gtest/gtest.h>
#include <omp.h>

#include "firmware/io/file_source.hpp"
#include "firmware/print/job/kept_prints.hpp"
#include "firmware/print/print_session.hpp"
#include "firmware/screen/kept_preview.hpp"
#include "hal/sim/sim_machine.hpp"
#include "tests/firmware/support/heap_trap.hpp"
#include "tests/firmware/support/job_fixture.hpp"
#include "tests/hil/session_rig.hpp"

namespace plumbline::firmware {
namespace {

alignas(64) std::byte print_arena[std::size_t{24} * 1024 * 1024];

TEST(Print, TakesNothingFromTheHeapFromItsAdmissionToItsReport) {
  const TemporaryFolder folder;
  write_sphere_scan(folder / "ball.ply", 4000, 2);
  omp_set_num_threads(2);
#pragma omp parallel  // the first region makes the threads
  static_cast<void>(omp_get_thread_num());
  const BoardFile board = session_board();
  const MachineFile machine_file = rig_machine();
  const PrintProfile profile = rig_profile();
  auto store = JobStore::open(folder / "state");
  ASSERT_TRUE(store) << store.error().message();
  auto scan = FileSource::open(folder / "ball.ply");
  ASSERT_TRUE(scan);
  PlantSettings settings = session_plant();
  // Each takes a different path through the firmware.
  for (const char* fault : {"cover.opens@layer=7+1s,for=5s", "stick.pulled@layer=3", "panel.slow@layer=9"}) {
    const auto parsed = parse_fault(fault);
    ASSERT_TRUE(parsed) << parsed.error().message();
    settings.faults.push_back(*parsed);
  }
  Plant plant(settings);
  SimMachine run(plant);
  Machine machine = run.machine();
  plant.timeline().at(TimePoint() + std::chrono::minutes(30), [&] { plant.press(EventKind::kStartPressed); });
  Silent observer;
  Arena arena(print_arena);
  PrintSession session(board, machine_file, arena, &*store);
  const SliceSettings slicing = slicing_for(board);

  HeapTrap trap;
  const auto sliced = slice_into(session, *scan, slicing, SupportSettings(), profile, machine_file, arena);
  const PrintReport report = sliced ? session.print(machine, observer) : PrintReport();
  const HeapUse use = trap.disarm();

  ASSERT_TRUE(sliced) << sliced.error().message();
  EXPECT_EQ(report.state, PrintState::kFinished) << report.fault_message.c_str();
  EXPECT_GT(report.exposures.size(), 50U);
  EXPECT_EQ(use.trapped, 0);
  if (use.trapped > 0) HeapTrap::print_stacks();
  EXPECT_GT(use.simulator, 0) << "the trap was armed during the print";
}

TEST(KeptPrint, IsWrittenReadAndShownWithoutTheHeap) {
  const TemporaryFolder folder;
  auto prints = KeptPrints::open(folder / ".", [](std::string_view) {});
  auto encoder = PictureEncoder::create(sizeof(PreviewPicture::memory));
  auto preview = KeptPreview::create();
  ASSERT_TRUE(prints && encoder && preview);
  const std::vector<std::uint8_t> pixels(std::size_t{3} * 320 * 100, 77);
  HeapTrap trap;
  bool kept = true, shown = true;
  for (std::uint32_t number = 1; number <= KeptPrints::kMost + 2; ++number) {
    const auto png = encoder->encode(pixels, 320, 100, PreviewPicture::kChannels);
    kept = kept && prints->keep(
                       {}, [](TextSink& out) { return out.write("{}"); }, png);
    const PreviewPicture* const picture = preview->of(*prints, number);
    shown = shown && picture != nullptr && picture->columns == 320 && picture->bytes().back() == 77;
  }
  const PreviewPicture* const dropped = preview->of(*prints, 1);
  const HeapUse use = trap.disarm();
  EXPECT_TRUE(kept && shown);
  EXPECT_EQ(dropped, nullptr);
  EXPECT_EQ(use.trapped, 0);
  if (use.trapped > 0) HeapTrap::print_stacks();
}

}  // namespace
}  // namespace plumbline::firmware
