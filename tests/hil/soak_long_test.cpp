/// Soaks: a hundred jobs in the same memory, three thousand layers on a 4K panel.

#include <gmock/gmock.h>
#include <gtest/gtest.h>
#include <unistd.h>

#include <fstream>

#include "tests/hil/session_rig.hpp"

namespace plumbline::firmware {
namespace {

using enum PrintState;

std::size_t resident_bytes() {
  std::ifstream statm("/proc/self/statm");
  std::size_t pages = 0;
  std::size_t resident = 0;
  statm >> pages >> resident;
  return resident * static_cast<std::size_t>(::sysconf(_SC_PAGESIZE));
}

TEST(Soak, HundredJobsRunInTheSameMemory) {
  DaemonRig rig;
  rig.put_scan("ball.ply", 1, 3000);
  rig.plant.plug_stick(rig.stick());
  std::vector<std::size_t> peaks;
  std::vector<std::size_t> resident;
  rig.user.on_printed = [&] {
    ASSERT_EQ(rig.user.reports.size(), 1U);
    EXPECT_EQ(rig.user.reports[0].state, kFinished);
    // What the plant and this test record would hide a leak of the firmware.
    rig.plant.conclude(JobEnd::kFinished);
    rig.plant.take_part_off();
    rig.user.forget();
    peaks.push_back(rig.arena.peak());
    resident.push_back(resident_bytes());
    rig.arena.reset_peak();
    rig.plant.press(peaks.size() < 100 ? EventKind::kStartPressed : EventKind::kShutdownRequested);
  };
  rig.user.on_words.emplace("ready", [&] { rig.plant.press(EventKind::kStartPressed); });
  ASSERT_TRUE(rig.run());
  ASSERT_EQ(peaks.size(), 100U);
  for (const auto peak : peaks) EXPECT_EQ(peak, peaks[0]);
  for (const auto& objection : rig.plant.objections()) ADD_FAILURE() << to_string(objection);
  // 2.7 kB a job.
  EXPECT_LE(resident.back(), resident[1] + (std::size_t{1} << 18U));
  std::printf("resident after job 2: %.3f MB, after job 100: %.3f MB\n", static_cast<double>(resident[1]) / 1e6,
              static_cast<double>(resident.back()) / 1e6);
}

TEST(Soak, ThreeThousandLayersOnThe4kPanel) {
  const auto board = read_board_file(PLUMBLINE_SOURCE_DIR "/board/mono4k.toml").value();
  const TemporaryFolder folder;
  write_sphere_scan(folder / "ball.ply", 200'000, 37.5);
  std::vector<std::byte> block(std::size_t{board.arena_mib} << 20U);
  Arena arena(block);
  PrintSession session(board, *board.machine, arena, nullptr);
  auto scan = FileSource::open(folder / "ball.ply");
  ASSERT_TRUE(scan);
  SliceSettings settings = slicing_for(board);
  settings.placement.layer_height_mm = 0.025F;
  auto profile = rig_profile();
  // Without supports the peel tears the ball off its tip.
  const auto sliced = slice_into(session, *scan, settings, SupportSettings(), profile, *board.machine, arena);
  ASSERT_TRUE(sliced) << sliced.error().message();
  EXPECT_GE(session.grid().layers, 3000U);

  auto plant_settings = plant_for(board);
  plant_settings.keep_part = false;
  Plant plant(plant_settings);
  SimMachine run(plant);
  Machine machine = run.machine();
  Silent observer;
  const auto& report = session.print(machine, observer);
  plant.conclude(JobEnd::kFinished);
  EXPECT_EQ(report.state, kFinished) << report.fault_message.c_str();
  for (const auto& objection : plant.objections()) ADD_FAILURE() << to_string(objection);
  const auto masks = session.mask_figures();
  EXPECT_GT(masks.smallest_slack, nanoseconds(0));
  std::printf("%u layers, %.1f ml; mask median %.3f ms, worst %.3f ms, %.1f times copying; smallest slack %.3f s\n",
              report.layers, report.resin_ml, static_cast<double>(masks.median_making.count()) / 1e6,
              static_cast<double>(masks.worst_making.count()) / 1e6, masks.ratio(),
              std::chrono::duration<double>(masks.smallest_slack).count());
}

}  // namespace
}  // namespace plumbline::firmware
