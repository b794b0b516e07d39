#include "slicer/rrep/confidence.hpp"

#include <algorithm>
#include <atomic>
#include <numeric>

namespace plumbline::inline slicer {
namespace {

constexpr const char* kStage = "confidence map";

constexpr std::uint8_t bit_of(Evidence evidence) {
  return static_cast<std::uint8_t>(1U << static_cast<std::uint32_t>(evidence));
}

Evidence strongest(std::uint8_t bits) {
  for (const Evidence evidence : {Evidence::kMeasured, Evidence::kBase}) {
    if ((bits & bit_of(evidence)) != 0) return evidence;
  }
  return Evidence::kWinding;
}

}  // namespace

const char* to_string(Evidence evidence) {
  switch (evidence) {
    case Evidence::kMeasured: return "measured";
    case Evidence::kWinding: return "winding number";
    case Evidence::kBase: return "base plane";
  }
  return "unknown";
}

std::size_t ConfidenceMap::bytes_needed(std::uint32_t layers) {
  return Arena::rounded(std::size_t{layers} * sizeof(Counts)) + Arena::rounded(kMostCells);
}

Expected<ConfidenceMap> ConfidenceMap::create(const PrintGrid& grid, const Box3f& box, float least_cell, Arena& arena) {
  ConfidenceMap map;
  map.grid_ = grid;
  map.low_ = box.low;
  const Vec3f size = box.size();
  float cell = std::max({least_cell, size.maxCoeff() / 256, 1e-3F});
  const auto fit = [&] {
    map.dims_ = (size / cell).array().cast<std::int64_t>() + 1;
    return map.dims_.prod() <= static_cast<std::int64_t>(kMostCells);
  };
  while (!fit()) cell *= 1.0625F;
  map.inverse_ = 1 / cell;
  PLUMBLINE_TRY(arena.take_bottom(map.layers_, grid.layers, kStage));
  PLUMBLINE_TRY(arena.take_bottom(map.cells_, kMostCells, kStage));
  std::fill(map.layers_.begin(), map.layers_.end(), Counts{});
  std::fill(map.cells_.begin(), map.cells_.end(), std::uint8_t{0});
  return map;
}

ConfidenceMap::Cell ConfidenceMap::cell_of(const Vec3f& p) const {
  return ((p - low_) * inverse_).array().max(0.0F).cast<std::int64_t>().min(dims_ - 1);
}

Vec3f ConfidenceMap::middle_of(std::uint32_t column, std::uint32_t row, std::uint32_t layer) const {
  return {grid_.x_of(column), grid_.y_of(row), (static_cast<float>(layer) + 0.5F) * grid_.layer_height_mm};
}

void ConfidenceMap::add(std::uint32_t column, std::uint32_t row, std::uint32_t layer, Evidence evidence) {
  if (layer < layers_.size()) {
    std::atomic_ref(layers_[layer][static_cast<std::size_t>(evidence)]).fetch_add(1, std::memory_order_relaxed);
  }
  std::uint8_t& cell = cells_[index(cell_of(middle_of(column, row, layer)))];
  const std::atomic_ref shared(cell);
  // The bit is nearly always set already, and reading is cheap.
  if ((shared.load(std::memory_order_relaxed) & bit_of(evidence)) == 0) {
    shared.fetch_or(bit_of(evidence), std::memory_order_relaxed);
  }
}

void ConfidenceMap::add_point(const Vec3f& p) { cells_[index(cell_of(p))] |= bit_of(Evidence::kMeasured); }

Status ConfidenceMap::raise(std::uint32_t layers, Arena& arena) {
  if (empty()) return {};
  const auto raised = arena.take_bottom<Counts>(layers_.size() + layers, kStage);
  PLUMBLINE_TRY(raised);
  std::fill(raised->begin(), raised->begin() + layers, Counts{});
  std::copy(layers_.begin(), layers_.end(), raised->begin() + layers);
  layers_ = *raised;
  low_[2] += static_cast<float>(layers) * grid_.layer_height_mm;
  return {};
}

void ConfidenceMap::trim(std::uint32_t below, std::uint32_t above) {
  if (empty()) return;
  layers_ = layers_.subspan(below, layers_.size() - below - above);
  low_[2] -= static_cast<float>(below) * grid_.layer_height_mm;
}

std::array<std::uint64_t, kEvidenceCount> ConfidenceMap::crossings() const {
  std::array<std::uint64_t, kEvidenceCount> sum{};
  for (const Counts& layer : layers_) {
    for (std::size_t e = 0; e < kEvidenceCount; ++e) sum[e] += layer[e];
  }
  return sum;
}

std::array<double, kEvidenceCount> ConfidenceMap::surface() const {
  // A plane in a random direction passes through 1.5 cells per area of a cell's face: the mean of |x| + |y| + |z| over the
  // unit sphere. The base plane is horizontal, so its area follows from its rays.
  constexpr double kCellsASide = 1.5;
  const double side = 1 / static_cast<double>(inverse_);
  std::array<double, kEvidenceCount> area{};
  Cell cell;
  for (cell[2] = 0; cell[2] < dims_[2]; ++cell[2]) {
    for (cell[1] = 0; cell[1] < dims_[1]; ++cell[1]) {
      for (cell[0] = 0; cell[0] < dims_[0]; ++cell[0]) {
        if (cells_[index(cell)] != 0) area[static_cast<std::size_t>(evidence_at(cell))] += side * side / kCellsASide;
      }
    }
  }
  const double pixel = static_cast<double>(grid_.pitch_x_mm) * static_cast<double>(grid_.pitch_y_mm);
  const auto flat = static_cast<std::size_t>(Evidence::kBase);
  area[flat] = static_cast<double>(crossings()[flat]) * pixel;
  const double all = std::accumulate(area.begin(), area.end(), 0.0);
  for (double& a : area) a = all > 0 ? a / all : 0;
  return area;
}

Evidence ConfidenceMap::evidence_at(const Cell& cell) const {
  const std::uint8_t own = cells_[index(cell)];
  if ((own & (bit_of(Evidence::kMeasured) | bit_of(Evidence::kBase))) != 0) return strongest(own);
  std::uint8_t bits = own;
  for (std::int64_t n = 0; n < 27; ++n) {
    const Cell other = cell + Cell(n % 3, n / 3 % 3, n / 9) - 1;
    if ((other >= 0).all() && (other < dims_).all()) bits |= cells_[index(other)];
  }
  // Within a cell of the scan the surface was seen, even where a grazing ray needed other evidence.
  if ((bits & bit_of(Evidence::kMeasured)) != 0) return Evidence::kMeasured;
  return strongest(own != 0 ? own : bits);
}

Evidence ConfidenceMap::at(std::uint32_t column, std::uint32_t row, std::uint32_t layer) const {
  return evidence_at(cell_of(middle_of(column, row, layer)));
}

}  // namespace plumbline::inline slicer
