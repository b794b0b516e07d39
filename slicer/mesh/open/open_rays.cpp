#include "slicer/mesh/open/open_rays.hpp"

#include <algorithm>
#include <cstdlib>

#include "slicer/core/numbers/mix64.hpp"

namespace plumbline::inline slicer {
namespace {

/// An empty stretch of this many cells is judged by the winding number in its middle.
constexpr float kTrusted = 2;
/// Layers between what is found on a ray inside of a square and what its corners foretell.
constexpr int kTolerance = 2;
/// Cells that a sheet may lie above or below the corners of its square.
constexpr float kBulge = 2;
/// A smaller square is not worth a test: its rays are asked one by one.
constexpr std::uint32_t kLeastSide = 4;

}  // namespace

OpenRays::OpenRays(const MeshField& field, const PrintGrid& grid, std::span<Ray> rays, const MeshRay& along)
    : field_(&field),
      grid_(&grid),
      rays_(rays),
      along_(along),
      long_gap_(field.layers_in(kTrusted, grid.layer_height_mm)) {}

Expected<OpenRays> OpenRays::create(const MeshField& field, const PrintGrid& grid, Arena& arena) {
  const auto rays = arena.take_top<Ray>(kSide * kSide, "mesh");
  PLUMBLINE_TRY(rays);
  const auto along = MeshRay::create(field, grid, arena);
  PLUMBLINE_TRY(along);
  return OpenRays(field, grid, *rays, *along);
}

void OpenRays::begin(const HitList& hits, std::uint32_t column, std::uint32_t row) {
  column_ = column;
  row_ = row;
  for (std::uint32_t r = 0; r < kSide; r += kTileSide) {
    for (std::uint32_t c = 0; c < kSide; c += kTileSide) {
      const std::uint32_t tile_column = (column + c) / kTileSide;
      const std::uint32_t tile_row = (row + r) / kTileSide;
      const bool in_grid = tile_column < hits.tile_columns() && tile_row < hits.tile_rows();
      auto in_tile =
          in_grid ? hits.of_tile(tile_row * hits.tile_columns() + tile_column) : std::span<const PackedHit>();
      const bool doubtful = in_grid && field_->doubtful.at(tile_column, tile_row);
      for (std::uint32_t i = 0; i < kRaysPerTile; ++i) {
        const std::uint32_t ray_c = c + i % kTileSide;
        const std::uint32_t ray_r = r + i / kTileSide;
        Ray& ray = at(ray_c, ray_r);
        ray.hits = hits.take_ray(in_tile, i);
        ray.doubtful = doubtful;
        ray.known = false;
        ray.count = 0;
        ray.kind = column + ray_c < grid_->columns && row + ray_r < grid_->rows ? kind_of(ray) : 0;
      }
    }
  }
  decide_square({0, 0, kSide});
}

std::uint64_t OpenRays::kind_of(const Ray& ray) const {
  if (ray.hits.empty() && !ray.doubtful) return 0;
  bool open = false;
  std::uint64_t kind = mix64(ray.hits.size() + 1);
  for_each_stretch(ray.hits, grid_->layers, [&](const RayStretch& stretch) {
    const bool asked = asks(ray, stretch);
    open |= asked;
    const auto windings = (std::uint64_t{static_cast<std::uint32_t>(stretch.from_below)} << 32U) |
                          static_cast<std::uint32_t>(stretch.from_above);
    kind = mix64(kind * kGoldenStep64 + windings + (asked ? 1 : 0));
    kind += static_cast<std::uint32_t>(stretch.from_all_above - stretch.from_above);
  });
  return open ? std::max<std::uint64_t>(kind, 1) : 0;
}

/// Finds the marks of an open ray.
/// @returns false if there is no room for them
bool OpenRays::ask(std::uint32_t c, std::uint32_t r) {
  Ray& ray = at(c, r);
  if (ray.known) return true;
  ++asked_;
  std::size_t count = 0;
  along_.begin(column_ + c, row_ + r, ray.hits);
  for_each_stretch(ray.hits, grid_->layers, [&](const RayStretch& stretch) {
    if (!asks(ray, stretch)) return;
    bool begins = true;
    along_.decide(stretch, [&](std::uint32_t layer, bool solid) {
      if (count < kMostMarks) ray.mark[count] = {static_cast<std::uint16_t>(layer), solid, begins};
      begins = false;
      ++count;
    });
  });
  ray.known = count <= kMostMarks;
  ray.count = static_cast<std::uint8_t>(ray.known ? count : 0);
  return ray.known;
}

/// Asks the rays in the corners.
/// @returns false if they don't pass the same sheets, or have other marks, whatever their layers
bool OpenRays::ask_corners(const Square& square, Corners& corners) {
  const std::uint32_t last = square.side - 1;
  std::size_t count = 0;
  for (const std::uint32_t r : {square.r, square.r + last}) {
    for (const std::uint32_t c : {square.c, square.c + last}) corners[count++] = &at(c, r);
  }
  const Ray& first = *corners[0];
  if (first.kind == 0) return false;
  if (std::ranges::any_of(corners, [&](const Ray* corner) { return corner->kind != first.kind; })) return false;
  for (const std::uint32_t r : {square.r, square.r + last}) {
    for (const std::uint32_t c : {square.c, square.c + last}) {
      if (!ask(c, r)) return false;
      const bool alike = std::ranges::equal(at(c, r).marks(), first.marks(), [](const Mark& a, const Mark& b) {
        return a.solid == b.solid && a.begins == b.begins;
      });
      if (!alike) return false;
    }
  }
  return true;
}

/// Whether the sheets that a ray passes are about as high as on the corners of its square, which are of its kind.
bool OpenRays::lies_between(const Ray& ray, const Corners& corners) const {
  const std::uint32_t bulge = field_->layers_in(kBulge, grid_->layer_height_mm);
  for (std::size_t i = 0; i < ray.hits.size(); ++i) {
    const auto [low, high] = std::minmax(
        {corners[0]->hits.layer(i), corners[1]->hits.layer(i), corners[2]->hits.layer(i), corners[3]->hits.layer(i)});
    const std::uint32_t layer = ray.hits.layer(i);
    if (layer + bulge < low || layer > high + bulge) return false;
  }
  return true;
}

/// Sets the marks of the ray at (dc, dr) in a square.
void OpenRays::interpolate(Ray& ray, const Square& square, const Corners& corners, std::uint32_t dc,
                           std::uint32_t dr) const {
  const std::uint32_t last = square.side - 1;
  const std::array<std::uint32_t, 4> weights = {(last - dc) * (last - dr), dc * (last - dr), (last - dc) * dr, dc * dr};
  ray.known = true;
  ray.count = corners[0]->count;
  for (std::size_t i = 0; i < ray.count; ++i) {
    std::uint32_t sum = last * last / 2;
    for (std::size_t k = 0; k < corners.size(); ++k) sum += weights[k] * corners[k]->mark[i].layer;
    ray.mark[i] = corners[0]->mark[i];
    ray.mark[i].layer = static_cast<std::uint16_t>(sum / (last * last));
  }
}

/// Whether the ray at (dc, dr) in a square is as the corners foretell.
bool OpenRays::foretells(const Square& square, const Corners& corners, std::uint32_t dc, std::uint32_t dr) {
  const Ray& ray = at(square.c + dc, square.r + dr);
  if (ray.kind != corners[0]->kind || !ask(square.c + dc, square.r + dr)) return false;
  Ray foretold;
  interpolate(foretold, square, corners, dc, dr);
  return std::ranges::equal(ray.marks(), foretold.marks(), [](const Mark& a, const Mark& b) {
    if (a.solid != b.solid || a.begins != b.begins) return false;
    return a.begins || std::abs(int{a.layer} - int{b.layer}) <= kTolerance;
  });
}

void OpenRays::decide_square(const Square& square) {
  const std::uint32_t half = square.side / 2;
  Corners corners{};
  bool smooth = ask_corners(square, corners) && foretells(square, corners, half, half);
  if (square.side > kTileSide) {
    const std::uint32_t quarter = half / 2;
    for (const std::uint32_t dr : {quarter, half + quarter}) {
      for (const std::uint32_t dc : {quarter, half + quarter}) {
        smooth = smooth && foretells(square, corners, dc, dr);
      }
    }
  }
  if (!smooth) {
    if (half < kLeastSide) return;
    for (const std::uint32_t r : {0U, half}) {
      for (const std::uint32_t c : {0U, half}) decide_square({square.c + c, square.r + r, half});
    }
    return;
  }
  for (std::uint32_t dr = 0; dr < square.side; ++dr) {
    for (std::uint32_t dc = 0; dc < square.side; ++dc) {
      Ray& ray = at(square.c + dc, square.r + dr);
      if (ray.known || ray.kind != corners[0]->kind || !lies_between(ray, corners)) continue;
      interpolate(ray, square, corners, dc, dr);
    }
  }
}

void OpenRays::decide(std::uint32_t column, std::uint32_t row, RayToggles& toggles) {
  const auto set = [&](std::uint32_t layer, bool solid) { toggles.set(layer, solid); };
  const Ray& ray = ray_at(column, row);
  asked_ += ray.known ? 0 : 1;
  if (!ray.known) along_.begin(column, row, ray.hits);
  std::span<const Mark> marks = ray.marks();
  for_each_stretch(ray.hits, grid_->layers, [&](const RayStretch& stretch) {
    if (!asks(ray, stretch)) {
      set(stretch.begin, stretch.is_solid());
    } else if (!ray.known) {
      along_.decide(stretch, set);
    } else {
      set(stretch.begin, marks.front().solid);
      marks = marks.subspan(1);
      for (std::uint32_t above = stretch.begin + 1; !marks.empty() && !marks.front().begins; marks = marks.subspan(1)) {
        const std::uint32_t layer = std::max<std::uint32_t>(marks.front().layer, above);
        if (layer < stretch.end) set(layer, marks.front().solid);
        above = layer + 1;
      }
    }
  });
}

}  // namespace plumbline::inline slicer
