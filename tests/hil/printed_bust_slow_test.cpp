/// The bust, scanned, sliced and printed on the simulated 2K printer, against its formula.

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <Eigen/LU>
#include <cstdio>

#include "firmware/sample/analytic_bust.hpp"
#include "firmware/sample/scan_sample.hpp"
#include "tests/hil/session_rig.hpp"

namespace plumbline {
namespace {

using enum PrintState;

TEST(PrintedBustSlow, OnTheSimulated2kPrinterIsTheBust) {
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
