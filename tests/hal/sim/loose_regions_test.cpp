/// What drops and what it shadows, in random layers, against brute force in voxels.

#include <gtest/gtest.h>

#include <random>
#include <vector>

#include "hal/sim/part/hanging_part.hpp"

namespace plumbline {
namespace {

/// The rules of HangingPart in voxels, by flooding; no peel.
struct Voxels {
  std::uint32_t columns, rows;
  std::vector<std::vector<bool>> stayed;
  std::vector<bool> film;
  double fell = 0, shadowed = 0;

  static std::vector<int> flood(const std::vector<bool>& image, std::uint32_t columns, std::uint32_t rows) {
    std::vector<int> label(image.size(), -1);
    int names = 0;
    for (std::size_t start = 0; start < image.size(); ++start) {
      if (!image[start] || label[start] >= 0) continue;
      std::vector<std::size_t> todo{start};
      label[start] = names;
      const auto visit = [&](std::size_t at) {
        if (!image[at] || label[at] >= 0) return;
        label[at] = names;
        todo.push_back(at);
      };
      while (!todo.empty()) {
        const std::size_t at = todo.back();
        todo.pop_back();
        if (at % columns > 0) visit(at - 1);
        if (at % columns + 1 < columns) visit(at + 1);
        if (at >= columns) visit(at - columns);
        if (at / columns + 1 < rows) visit(at + columns);
      }
      ++names;
    }
    return label;
  }

  void add(const std::vector<bool>& asked) {
    film.resize(asked.size());
    std::vector<bool> lit(asked.size());
    for (std::size_t i = 0; i < asked.size(); ++i) lit[i] = asked[i] && !film[i];
    const auto label = flood(lit, columns, rows);
    std::vector<bool> held(asked.size(), stayed.empty());
    if (!stayed.empty()) {
      for (std::size_t i = 0; i < asked.size(); ++i) {
        if (lit[i] && stayed.back()[i]) held[static_cast<std::size_t>(label[i])] = true;
      }
    }
    std::vector<bool> stays(asked.size());
    for (std::size_t i = 0; i < asked.size(); ++i) {
      stays[i] = lit[i] && held[static_cast<std::size_t>(label[i])];
      if (lit[i] && !stays[i]) film[i] = true;
    }
    const auto region = flood(asked, columns, rows);
    std::vector<bool> region_stays(asked.size());
    for (std::size_t i = 0; i < asked.size(); ++i) {
      if (stays[i]) region_stays[static_cast<std::size_t>(region[i])] = true;
    }
    for (std::size_t i = 0; i < asked.size(); ++i) {
      if (!asked[i] || stays[i]) continue;
      (region_stays[static_cast<std::size_t>(region[i])] ? shadowed : fell) += 1;
    }
    stayed.push_back(stays);
  }
};

TEST(LooseRegions, DropsAndShadowsWhatBruteForceDoes) {
  std::mt19937 random(5);
  constexpr std::uint32_t kColumns = 90;
  constexpr std::uint32_t kRows = 40;
  PeelSettings gentle;
  gentle.traction_kpa = gentle.line_force_n_mm = gentle.suction_kpa = 0;
  double fell = 0;
  double shadowed = 0;
  for (int run = 0; run < 30; ++run) {
    HangingPart part(
        {.columns = kColumns, .rows = kRows, .pitch_x_mm = 1, .pitch_y_mm = 1, .peel = gentle, .remember = true});
    part.begin(false);
    Voxels voxels{.columns = kColumns, .rows = kRows, .stayed = {}, .film = {}};
    struct Blob {
      double x, y, z, r;
    };
    std::vector<Blob> blobs;
    std::uniform_real_distribution<double> unit(0, 1);
    for (int i = 0; i < 40; ++i)
      blobs.push_back({90 * unit(random), 40 * unit(random), 40 * unit(random), 2 + 7 * unit(random)});
    for (std::uint32_t k = 0; k < 40; ++k) {
      std::vector<std::uint64_t> asked(BitImage::words_needed(kColumns, kRows), 0);
      std::vector<bool> flat(kColumns * kRows);
      for (std::uint32_t y = 0; y < kRows; ++y) {
        for (std::uint32_t x = 0; x < kColumns; ++x) {
          for (const Blob& b : blobs) {
            if ((x - b.x) * (x - b.x) + (y - b.y) * (y - b.y) + (k - b.z) * (k - b.z) > b.r * b.r) continue;
            BitImage(asked, kColumns, kRows).set(x, y);
            flat[y * kColumns + x] = true;
          }
        }
      }
      std::vector<std::uint64_t> lit = asked;
      for (std::size_t i = 0; i < lit.size(); ++i) lit[i] &= ~part.film().words()[i];
      const BitImage image(lit, kColumns, kRows);
      part.add_layer(k, 1, 1, image, ConstBitImage(asked, kColumns, kRows));
      voxels.add(flat);
      for (std::uint32_t y = 0; y < kRows; ++y) {
        for (std::uint32_t x = 0; x < kColumns; ++x) {
          ASSERT_EQ(image.at(x, y), voxels.stayed.back()[y * kColumns + x]) << run << " " << k << " " << x << " " << y;
          ASSERT_EQ(part.film().at(x, y), voxels.film[y * kColumns + x]);
        }
      }
    }
    double found_fell = 0;
    double found_shadowed = 0;
    for (const Loss& loss : part.losses()) {
      EXPECT_NE(loss.kind, LossKind::kTorn);
      (loss.kind == LossKind::kDropped ? found_fell : found_shadowed) += 1000 * loss.ml;
    }
    EXPECT_NEAR(found_fell, voxels.fell, 1e-6);
    EXPECT_NEAR(found_shadowed, voxels.shadowed, 1e-6);
    fell += voxels.fell;
    shadowed += voxels.shadowed;
  }
  EXPECT_GT(fell, 1e4);
  EXPECT_GT(shadowed, 1e4);
}

}  // namespace
}  // namespace plumbline
