/// Benchmarks of the slicer's inner work, in units that do not depend on the scan: a mask, a neighbourhood, a row of rays.

#include <benchmark/benchmark.h>

#include <algorithm>
#include <chrono>
#include <cmath>
#include <cstring>
#include <stdexcept>
#include <vector>

#include "slicer/cloud/cloud_reader.hpp"
#include "slicer/core/numbers/median.hpp"
#include "slicer/implicit/winding_number.hpp"
#include "slicer/layers/layer_stream.hpp"
#include "slicer/rays/grid_width.hpp"
#include "slicer/rays/ray_classifier.hpp"
#include "tests/slicer/reader/scan_fixture.hpp"
#include "tests/slicer/support/arena_block.hpp"
#include "tests/slicer/support/scan_cloud.hpp"

namespace plumbline::firmware {
namespace {

using namespace testing;

/// An ellipsoid that fills panel and travel: half of the pixels, two crossings each.
class Ellipsoid {
 public:
  Ellipsoid(std::uint32_t columns, std::uint32_t rows, std::uint32_t layers) {
    std::vector<std::vector<std::uint32_t>> by_layer(layers);
    for (std::uint32_t r = 0; r < rows; ++r) {
      for (std::uint32_t c = 0; c < columns; ++c) {
        const double u = 2.0 * (c + 0.5) / columns - 1;
        const double v = 2.0 * (r + 0.5) / rows - 1;
        const double rest = 1 - u * u - v * v;
        if (rest <= 0) continue;
        const auto half = static_cast<std::uint32_t>(0.5 * (layers - 2) * std::sqrt(rest));
        by_layer[layers / 2 - half].push_back(r * columns + c);
        by_layer[layers / 2 + half + 1].push_back(r * columns + c);
      }
    }
    for (const auto& pixels : by_layer) {
      first_.push_back(static_cast<std::uint32_t>(pixel_.size()));
      pixel_.insert(pixel_.end(), pixels.begin(), pixels.end());
    }
    first_.push_back(static_cast<std::uint32_t>(pixel_.size()));
    rrep_ = {{.columns = columns, .rows = rows, .layers = layers}, first_, pixel_};
  }
  Ellipsoid(const Ellipsoid&) = delete;
  Ellipsoid& operator=(const Ellipsoid&) = delete;
  const RRep& rrep() const { return rrep_; }

 private:
  std::vector<std::uint32_t> first_, pixel_;
  RRep rrep_;
};

void panels(benchmark::internal::Benchmark* benchmark) {
  benchmark->Args({1440, 2560})->Args({3840, 2400})->ArgNames({"columns", "rows"})->Unit(benchmark::kMicrosecond);
}

std::int64_t mask_bytes(std::int64_t columns, std::int64_t rows) { return columns * rows / 8; }

/// The next mask of a print without supports, opened and closed: mean over all layers.
void mask_of_a_layer(benchmark::State& state) {
  constexpr std::uint32_t kLayers = 2000;
  const Ellipsoid solid(static_cast<std::uint32_t>(state.range(0)), static_cast<std::uint32_t>(state.range(1)),
                        kLayers);
  ArenaBlock arena(8 * kMiB);
  LayerStream stream = value_of(LayerStream::create(solid.rrep(), *arena));
  std::uint32_t layer = 0;
  while (state.KeepRunning()) {
    benchmark::DoNotOptimize(stream.mask(layer).row(0).data());
    benchmark::ClobberMemory();
    layer = (layer + 1) % kLayers;  // layer 0 starts from nothing
  }
  state.SetBytesProcessed(state.iterations() * mask_bytes(state.range(0), state.range(1)));
}
BENCHMARK(mask_of_a_layer)->Apply(panels);

/// What a print has, layer by layer: making the mask, then copying it into the panel's buffer. Each layer counts with its shortest
/// time of all passes. The counters are the median and the worst mask over the median copy.
void masks_of_a_print(benchmark::State& state) {
  constexpr std::uint32_t kLayers = 2000;
  const Ellipsoid solid(static_cast<std::uint32_t>(state.range(0)), static_cast<std::uint32_t>(state.range(1)),
                        kLayers);
  ArenaBlock arena(8 * kMiB);
  LayerStream stream = value_of(LayerStream::create(solid.rrep(), *arena));
  std::vector<std::uint64_t> panel(stream.mask(0).words().size());
  using Clock = std::chrono::steady_clock;
  std::vector<Clock::duration> making(kLayers, Clock::duration::max());
  std::vector<Clock::duration> copying(kLayers, Clock::duration::max());
  while (state.KeepRunning()) {
    for (std::uint32_t layer = 0; layer < kLayers; ++layer) {
      const auto start = Clock::now();
      const ConstBitImage mask = stream.mask(layer);
      const auto made = Clock::now();
      std::copy(mask.words().begin(), mask.words().end(), panel.begin());
      benchmark::ClobberMemory();
      copying[layer] = std::min(copying[layer], Clock::now() - made);
      making[layer] = std::min(making[layer], made - start);
    }
  }
  const auto copy = static_cast<double>(median(std::span(copying)).count());
  state.counters["worst"] = static_cast<double>(std::max_element(making.begin(), making.end())->count()) / copy;
  state.counters["median"] = static_cast<double>(median(std::span(making)).count()) / copy;
}
BENCHMARK(masks_of_a_print)->Apply(panels)->Iterations(20);

/// Copying a mask: the lower bound for mask_of_a_layer.
void copy_of_a_mask(benchmark::State& state) {
  const auto bytes = static_cast<std::size_t>(mask_bytes(state.range(0), state.range(1)));
  const std::vector<std::byte> from(bytes, std::byte{0x55});
  std::vector<std::byte> to(bytes);
  while (state.KeepRunning()) {
    std::memcpy(to.data(), from.data(), bytes);
    benchmark::ClobberMemory();
  }
  state.SetBytesProcessed(state.iterations() * static_cast<std::int64_t>(bytes));
}
BENCHMARK(copy_of_a_mask)->Apply(panels);

/// A noisy scan of a sphere of radius 30 mm.
Surface scan(std::uint32_t points) {
  Random random(71);
  Surface surface = sphere(points, 30, Vec3d(32, 32, 32));
  add_noise(surface, 0.02, 0.05, random);
  shuffle(surface, random);
  return surface;
}

/// A scan with twice the points that there is room for: in the order of a spiral from top to bottom, or in random order.
void read_and_thin(benchmark::State& state) {
  constexpr std::uint32_t kRoom = 1'700'000;  // of a 2K panel in 96 MiB
  Random random(72);
  Surface surface = sphere(2 * kRoom, 30, Vec3d::Zero());
  if (state.range(0) != 0) shuffle(surface, random);
  const std::string bytes = binary_ply(surface);
  ArenaBlock arena(96 * kMiB);
  while (state.KeepRunning()) {
    const ArenaScope scope(*arena);
    MemorySource source(bytes, "sphere.ply");
    ByteSource* const sources[] = {&source};
    const auto room = [&](const ScanAnnouncement&) { return Expected<std::uint32_t>(kRoom); };
    const CloudReading read = value_of(read_cloud(sources, {.first_cell = 0.02}, room, *arena, nullptr));
    if (read.averaged < kRoom) throw std::runtime_error("the scan was not thinned");
  }
  state.SetBytesProcessed(state.iterations() * static_cast<std::int64_t>(bytes.size()));
}
BENCHMARK(read_and_thin)->Arg(0)->Arg(1)->ArgName("random")->Unit(benchmark::kMillisecond);

/// The nearest neighbours of each point in the order of the tree, as clustering and normals search them.
void nearest_neighbours(benchmark::State& state) {
  constexpr std::uint32_t kPoints = 300'000;
  ArenaBlock arena(64 * kMiB);
  Cloud cloud = cloud_of(scan(kPoints), *arena);
  const KdTree3 tree = sort_by_tree(cloud, *arena);
  std::vector<Neighbour> found(static_cast<std::size_t>(state.range(0)));
  std::uint32_t i = 0;
  while (state.KeepRunning()) {
    benchmark::DoNotOptimize(tree.nearest(cloud.position[i], found));
    i = (i + 1) % kPoints;
  }
  state.SetItemsProcessed(state.iterations());
}
BENCHMARK(nearest_neighbours)->Arg(10)->Arg(60)->ArgName("k");

/// A row of tiles of rays, from one edge of the sphere to the other.
void row_of_ray_tiles(benchmark::State& state) {
  constexpr float kPitch = 0.05F;
  constexpr std::uint32_t kSide = 1280;
  constexpr std::uint32_t kTile = kTileSide;
  ArenaBlock arena(128 * kMiB);
  const ClusteredScan scanned = clustered(scan(static_cast<std::uint32_t>(state.range(0))), *arena);
  const auto nodes = value_of(arena->take_top<DipoleNode>(WindingTree::nodes_needed(scanned.cloud.size), "bench"));
  const WindingTree winding = WindingTree::build(scanned.cloud, nodes);
  const PrintGrid grid{.columns = kSide,
                       .rows = kSide,
                       .layers = kSide,
                       .pitch_x_mm = kPitch,
                       .pitch_y_mm = kPitch,
                       .layer_height_mm = kPitch};
  const RayField field{.cloud = &scanned.cloud,
                       .tree = &scanned.tree,
                       .winding = &winding,
                       .grid = grid,
                       .width = grid_width(scanned.cloud, scanned.tree),
                       .widths = scanned.widths(),
                       .tile_capacity = 32768};
  RayClassifier classifier = value_of(RayClassifier::create(field, *arena));
  const std::uint32_t row = kSide / 2 / kTile * kTile;
  while (state.KeepRunning()) {
    std::size_t crossings = 0;
    for (std::uint32_t column = 0; column < kSide; column += kTile) {
      classifier.begin_tile(column, row);
      for (std::uint32_t r = row; r < row + kTile; ++r) {
        for (std::uint32_t c = column; c < column + kTile; ++c) crossings += classifier.ray(c, r).crossings.size();
      }
    }
    if (crossings < kSide * kTile) throw std::runtime_error("the rays do not meet the sphere");
  }
  state.SetItemsProcessed(state.iterations() * kSide * kTile);
}
BENCHMARK(row_of_ray_tiles)->Arg(100'000)->Arg(300'000)->ArgName("points")->Unit(benchmark::kMillisecond);

}  // namespace
}  // namespace plumbline::firmware
