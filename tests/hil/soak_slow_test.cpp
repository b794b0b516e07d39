/// What takes minutes: a hundred jobs, three thousand layers on a 4K panel, the bust against its formula.

#include <gmock/gmock.h>
#include <gtest/gtest.h>
#include <unistd.h>

#include <Eigen/LU>
#include <fstream>

#include "firmware/sample/analytic_bust.hpp"
#include "firmware/sample/scan_sample.hpp"
#include "tests/hil/session_rig.hpp"

namespace plumbline {
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
    rig.user.states.clear();  // the test's own
    peaks.push_back(rig.arena.peak());
    resident.push_back(resident_bytes());
    rig.arena.reset_peak();
    rig.plant.press(rig.user.reports.size() < 100 ? EventKind::kStartPressed : EventKind::kShutdownRequested);
  };
  ASSERT_TRUE(rig.run());
  ASSERT_EQ(rig.user.reports.size(), 100U);
  for (const auto& report : rig.user.reports) EXPECT_EQ(report.state, kFinished);
  for (const auto peak : peaks) EXPECT_EQ(peak, peaks[0]);
  // The plant and this test remember every light; the firmware nothing.
  EXPECT_LE(resident.back() - resident[1], std::size_t{1} << 20U);
  std::printf("resident after job 2: %.2f MB, after job 100: %.2f MB\n", static_cast<double>(resident[1]) / 1e6,
              static_cast<double>(resident.back()) / 1e6);
}

PlantSettings plant_for(const BoardFile& board) {
  PlantSettings settings = rig_plant();
  settings.panel.columns = board.columns;
  settings.panel.rows = board.rows;
  settings.panel.pitch_x_mm = board.pixel_pitch_x_mm;
  settings.panel.pitch_y_mm = board.pixel_pitch_y_mm;
  settings.lamp.irradiance = Irradiance(board.machine->power_mw_cm2);
  settings.pace.computing = 1;
  return settings;
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
  const auto sliced = session.slice_scan(*scan, settings, std::nullopt, profile, nullptr);
  ASSERT_TRUE(sliced) << sliced.error().message();
  EXPECT_NEAR(session.grid().layers, 3000, 2);

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

TEST(Soak, BustOnTheSimulated2kPrinterIsTheBust) {
  const auto board = read_board_file(PLUMBLINE_SOURCE_DIR "/board/sim2k.toml").value();
  const TemporaryFolder folder;
  ASSERT_TRUE(write_bust_scan(folder / "bust.ply", {}, [](double) { return true; }));
  std::vector<std::byte> block(std::size_t{board.arena_mib} << 20U);
  Arena arena(block);
  PrintSession session(board, *board.machine, arena, nullptr);
  auto scan = FileSource::open(folder / "bust.ply");
  ASSERT_TRUE(scan);
  const SliceSettings settings = slicing_for(board);
  const auto profile = read_print_profile(PLUMBLINE_SOURCE_DIR "/board/profiles/standard.toml").value();
  const auto sliced = session.slice_scan(*scan, settings, std::nullopt, profile, nullptr);
  ASSERT_TRUE(sliced) << sliced.error().message();

  Plant plant(plant_for(board));
  SimMachine run(plant);
  Machine machine = run.machine();
  Silent observer;
  const auto& report = session.print(machine, observer);
  plant.conclude(JobEnd::kFinished);
  ASSERT_EQ(report.state, kFinished) << report.fault_message.c_str();
  for (const auto& objection : plant.objections()) ADD_FAILURE() << to_string(objection);

  // Voxel by voxel, at the height at which a layer is the section of the object.
  const Mat4d to_scan = session.sliced().placement.transform().inverse();
  const PrintGrid& grid = session.grid();
  std::uint64_t both = 0;
  std::uint64_t either = 0;
  std::uint32_t layer = 0;
  plant.part().for_each_layer([&](const CuredLayer&, ConstBitImage cured) {
    const double z = (layer + 0.5) * static_cast<double>(grid.layer_height_mm);
    // A ninth of the voxels of every layer, in a pattern that leaves no column out.
    for (std::uint32_t y = layer % 3; y < grid.rows; y += 3) {
      for (std::uint32_t x = y % 3; x < grid.columns; x += 3) {
        const Eigen::Vector4d at((x + 0.5) * static_cast<double>(grid.pitch_x_mm),
                                 (y + 0.5) * static_cast<double>(grid.pitch_y_mm), z, 1);
        const bool printed = cured.at(x, y);
        const Eigen::Vector4d place = to_scan * at;
        const bool bust = bust_inside(place.head<3>());
        both += printed && bust ? 1 : 0;
        either += printed || bust ? 1 : 0;
      }
    }
    ++layer;
  });
  const double iou = static_cast<double>(both) / static_cast<double>(either);
  std::printf("bust: IoU %.5f over %llu voxels\n", iou, static_cast<unsigned long long>(either));
  EXPECT_GE(iou, 0.995);
}

}  // namespace
}  // namespace plumbline
