/// Slices real scans, if they are present beside the repository.

#include <gtest/gtest.h>

#include <algorithm>
#include <filesystem>
#include <numeric>
#include <string>
#include <vector>

#include "tests/slicer/support/shared_scan.hpp"
#include "tests/slicer/support/slicing.hpp"

namespace plumbline {
namespace {

using namespace testing;

/// Connected solids of a stack of masks, from runs of white pixels. Voxels touch at faces.
class Solids {
 public:
  void add(ConstBitImage mask) {
    std::vector<std::vector<Run>> layer(mask.rows());
    for (std::uint32_t r = 0; r < mask.rows(); ++r) {
      for (std::uint32_t c = 0; c < mask.columns();) {
        if (!mask.at(c, r)) {
          ++c;
          continue;
        }
        const std::uint32_t first = c;
        while (c < mask.columns() && mask.at(c, r)) ++c;
        layer[r].push_back({first, c, static_cast<std::uint32_t>(parent_.size())});
        parent_.push_back(static_cast<std::uint32_t>(parent_.size()));
        voxels_.push_back(c - first);
      }
      if (r > 0) join(layer[r - 1], layer[r]);
      if (!below_.empty()) join(below_[r], layer[r]);
    }
    below_ = std::move(layer);
  }

  /// Voxels of each solid, largest first.
  std::vector<std::uint64_t> sizes() {
    std::vector<std::uint64_t> sum(parent_.size(), 0);
    for (std::uint32_t i = 0; i < parent_.size(); ++i) sum[root(i)] += voxels_[i];
    std::erase(sum, 0U);
    std::sort(sum.rbegin(), sum.rend());
    return sum;
  }

 private:
  struct Run {
    std::uint32_t first, last, number;
  };
  std::uint32_t root(std::uint32_t i) {
    while (parent_[i] != i) i = parent_[i] = parent_[parent_[i]];
    return i;
  }
  void join(const std::vector<Run>& a, const std::vector<Run>& b) {
    for (std::size_t i = 0, j = 0; i < a.size() && j < b.size();) {
      if (a[i].first < b[j].last && b[j].first < a[i].last) parent_[root(a[i].number)] = root(b[j].number);
      ++(a[i].last < b[j].last ? i : j);
    }
  }
  std::vector<std::uint32_t> parent_;
  std::vector<std::uint64_t> voxels_;
  std::vector<std::vector<Run>> below_;
};

void expect_a_whole_body(const std::string& name, double tallest_mm) {
  const std::filesystem::path path = shared_scan(name);
  if (!std::filesystem::exists(path)) GTEST_SKIP() << "needs " << path << ", which is not part of the repository";
  const std::string bytes = content_of(path);

  // The scale makes up for any unit of the scan.
  SliceSettings settings = settings_with_pitch(0.1F);
  settings.placement.printer = PrinterVolume{2000, 2000, 0.1F, 0.1F, static_cast<float>(tallest_mm)};
  settings.placement.fit = true;
  Slicing sliced(bytes, settings, 512 * kMiB);
  EXPECT_GT(sliced.report().placement.size_mm[2], 0.5 * tallest_mm);

  Solids solids;
  LayerStream stream = value_of(LayerStream::create(sliced.rrep(), sliced.arena()));
  const std::uint32_t layers = sliced.grid().layers;
  std::uint64_t voxels = 0;
  for (std::uint32_t k = 0; k < layers; ++k) {
    const ConstBitImage mask = stream.mask(k);
    voxels += mask.count();
    if (k >= 0.02 * layers && k <= 0.98 * layers) {
      EXPECT_GT(mask.count(), 0U) << "layer " << k << " of " << layers;
    }
    solids.add(mask);
  }
  const std::vector<std::uint64_t> sizes = solids.sizes();
  ASSERT_FALSE(sizes.empty());
  EXPECT_GT(static_cast<double>(sizes[0]), 0.995 * static_cast<double>(voxels));
  EXPECT_LE(sizes.size(), 20U) << "specks";
  ::testing::Test::RecordProperty("pieces", static_cast<int>(sizes.size()));
}

TEST(SharedScansSlow, TheRawBunnyIsOneWholeBody) { expect_a_whole_body("bunny_raw.ply", 80); }
TEST(SharedScansSlow, TheRawDragonIsOneWholeBody) { expect_a_whole_body("dragon_raw.ply", 80); }

}  // namespace
}  // namespace plumbline
