/// The bust, scanned, sliced and printed on the simulated 2K printer, against its formula.

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <Eigen/LU>
#include <algorithm>
#include <cstdio>
#include <vector>

#include "firmware/sample/analytic_bust.hpp"
#include "firmware/sample/scan_sample.hpp"
#include "slicer/checks/stack_checker.hpp"
#include "slicer/layers/layer_stream.hpp"
#include "slicer/supports/drawing/support_painter.hpp"
#include "tests/hil/session_rig.hpp"

namespace plumbline::firmware {
namespace {

using enum PrintState;

/// The bust on the simulated 2K printer.
class PrintedBustSlow : public testing::Test {
 protected:
  void print(const std::optional<SupportSettings>& supports) {
    const TemporaryFolder folder;
    ASSERT_TRUE(write_bust_scan(folder / "bust.ply", {}, [](double) { return true; }));
    auto scan = FileSource::open(folder / "bust.ply");
    ASSERT_TRUE(scan);
    const auto profile = read_print_profile(PLUMBLINE_SOURCE_DIR "/board/profiles/standard.toml").value();
    const auto sliced = slice_into(session, *scan, slicing_for(board), supports, profile, *board.machine, arena);
    ASSERT_TRUE(sliced) << sliced.error().message();
    Machine machine = run.machine();
    Silent observer;
    const auto& report = session.print(machine, observer);
    plant.conclude(JobEnd::kFinished);
    ASSERT_EQ(report.state, kFinished) << report.fault_message.c_str();
  }

  BoardFile board = read_board_file(PLUMBLINE_SOURCE_DIR "/board/sim2k.toml").value();
  std::vector<std::byte> block = std::vector<std::byte>(std::size_t{board.arena_mib} << 20U);
  Arena arena{block};
  PrintSession session{board, *board.machine, arena, nullptr};
  Plant plant{plant_for(board)};
  SimMachine run{plant};
};

TEST_F(PrintedBustSlow, IsTheBust) {
  ASSERT_NO_FATAL_FAILURE(print(SupportSettings()));
  for (const auto& objection : plant.objections()) ADD_FAILURE() << to_string(objection);

  // Voxel by voxel, at the height at which a layer is the section of the object. Supports outside of the bust don't count.
  const Mat4d to_scan = session.printable().slice.placement.transform().inverse();
  const PrintGrid& grid = session.grid();
  auto painter = SupportPainter::create(session.printable().parts.supports, arena);
  ASSERT_TRUE(painter);
  std::vector<std::uint64_t> support_words(BitImage::words_needed(grid.columns, grid.rows));
  const BitImage supports(support_words, grid.columns, grid.rows);
  std::vector<std::uint64_t> touched(BitImage::words_needed(grid.rows, 2 * supports.stride()));
  std::uint64_t both = 0;
  std::uint64_t either = 0;
  std::uint32_t layer = 0;
  plant.part().for_each_layer([&](const CuredLayer&, ConstBitImage cured) {
    supports.clear();
    painter->draw(layer, supports, BitImage(touched, grid.rows, 2 * supports.stride()));
    const double z = (layer + 0.5) * static_cast<double>(grid.layer_height_mm);
    // A ninth of the voxels of every layer, in a pattern that leaves no column out.
    for (std::uint32_t y = layer % 3; y < grid.rows; y += 3) {
      for (std::uint32_t x = y % 3; x < grid.columns; x += 3) {
        const Eigen::Vector4d at((x + 0.5) * static_cast<double>(grid.pitch_x_mm),
                                 (y + 0.5) * static_cast<double>(grid.pitch_y_mm), z, 1);
        const bool printed = cured.at(x, y);
        const Eigen::Vector4d place = to_scan * at;
        const bool bust = bust_inside(place.head<3>());
        if (supports.at(x, y) && !bust) continue;
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

TEST_F(PrintedBustSlow, LosesWithoutSupportsWhatTheSweepForetells) {
  ASSERT_NO_FATAL_FAILURE(print(std::nullopt));
  auto layers = LayerStream::create(session.printable().parts.rrep, arena);
  ASSERT_TRUE(layers);
  auto checker = StackChecker::create(session.grid(), {}, arena);
  ASSERT_TRUE(checker) << checker.error().message();
  for (std::uint32_t k = 0; k < session.grid().layers; ++k) checker->next(layers->mask(k));
  const StackFindings foretold = checker->finish();
  const IssueGroup& pieces = foretold.of(IssueKind::kFreePiece);
  ASSERT_GE(pieces.count, 1U) << "the bun begins in the air";
  const auto losses = [&](ObjectionKind kind) {
    std::vector<Loss> all;
    for (const Objection& objection : plant.objections()) {
      if (objection.kind == kind) all.push_back(*objection.loss);
    }
    std::sort(all.begin(), all.end(), [](const Loss& a, const Loss& b) { return a.ml > b.ml; });
    return all;
  };
  const auto dropped = losses(ObjectionKind::kDropped);
  const auto shadowed = losses(ObjectionKind::kShadowed);
  ASSERT_THAT(dropped, testing::SizeIs(pieces.count));
  ASSERT_THAT(shadowed, testing::SizeIs(1));
  ASSERT_THAT(plant.objections(), testing::SizeIs(pieces.count + 1));
  const Loss& bun = dropped.front();
  EXPECT_EQ(bun.layer, pieces.kept[0].first_layer);
  EXPECT_EQ(bun.last_layer, pieces.kept[0].last_layer);
  const double foretold_ml = static_cast<double>(pieces.kept[0].voxels) * session.pixel_ml();
  EXPECT_NEAR(bun.ml, foretold_ml, 0.02 * foretold_ml);
  EXPECT_LT(static_cast<double>(pieces.voxels - pieces.kept[0].voxels), 0.01 * static_cast<double>(pieces.voxels))
      << "what else falls is a speck";
  const double shadowed_ml = static_cast<double>(foretold.shadowed_voxels) * session.pixel_ml();
  EXPECT_NEAR(shadowed[0].ml, shadowed_ml, 0.02 * shadowed_ml);
  EXPECT_GT(shadowed_ml, bun.ml) << "its shadow takes more than it";
}

}  // namespace
}  // namespace plumbline::firmware
