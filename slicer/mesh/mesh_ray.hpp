#pragma once
/// The winding number of a mesh along one ray.

#include <algorithm>
#include <array>
#include <cmath>
#include <cstdint>
#include <optional>
#include <utility>

#include "slicer/core/bit_image.hpp"
#include "slicer/core/print_grid.hpp"
#include "slicer/implicit/winding_number.hpp"
#include "slicer/mesh/open/rim_winding.hpp"
#include "slicer/mesh/ray_solids.hpp"

namespace plumbline::inline slicer {

/// The winding number of a mesh that is not closed.
struct MeshField {
  MeshRim rim;                         ///< empty: it is too long, and all triangles are in `winding`
  std::optional<WindingTree> winding;  ///< none: by the rim
  std::optional<float> base;           ///< mm: with a rim, the height at which the surface is mirrored
  float cell =
      0;  ///< mm: details that are smaller are not looked for. Nearer to the surface the tree's number is not trusted
  BitImage doubtful;  ///< one pixel a tile: where the hits miss solid parts. Set by find_doubtful()
  std::uint32_t first_column = 0, end_column = 0;  ///< tiles that the object's box covers
  std::uint32_t first_row = 0, end_row = 0;

  /// Whether an open underside is closed flat.
  bool has_base() const { return winding ? winding->has_base() : base.has_value(); }
  /// Layers in a number of cells, at least 1.
  std::uint32_t layers_in(float cells, float layer_height) const {
    return static_cast<std::uint32_t>(std::clamp(cells * cell / layer_height, 1.0F, 65535.0F));
  }
};

/// One ray after the other. One object a thread.
class MeshRay {
 public:
  static std::size_t bytes_needed(const MeshField& field) {
    return field.winding ? 0 : RimWinding::bytes_needed(field.rim.corners.size());
  }
  /// @param field  outlives this, as does the grid
  /// @param arena  bytes_needed() from the top
  /// @retval ErrorCode::kOutOfMemory
  [[nodiscard]] static Expected<MeshRay> create(const MeshField& field, const PrintGrid& grid, Arena& arena) {
    MeshRay ray(field, grid);
    if (!field.winding) {
      const auto rim = RimWinding::create(field.rim, arena);
      PLUMBLINE_TRY(rim);
      ray.rim_ = *rim;
    }
    return ray;
  }

  /// Begins the ray through a pixel.
  void begin(std::uint32_t column, std::uint32_t row, const RayHits& hits) {
    x_ = grid_->x_of(column);
    y_ = grid_->y_of(row);
    below_all_ = -winding_sum_of_all(hits);
    if (rim_) rim_->begin(column, row);
  }

  /// What a place is, and whether plainly: far from where the surface may lie.
  struct Side {
    bool solid = false;
    bool plain = false;
  };
  /// @param above  RayStretch::from_all_above
  bool inside(std::uint32_t layer, int above) const { return side(layer, above).solid; }
  Side side(std::uint32_t layer, int above) const {
    const float z = (static_cast<float>(layer) + 0.5F) * grid_->layer_height_mm;
    if (rim_) return rim_side(z, above);
    // Most places are so plainly inside or outside that a rough number tells.
    constexpr float kPlain = WindingLean::kMost + WindingTree::kRough;
    const Vec3f place(x_, y_, z);
    const float rough = field_->winding->rough(place);
    if (std::abs(rough - WindingTree::kSurface) > kPlain) return {rough > WindingTree::kSurface, true};
    return {field_->winding->inside(place), false};
  }
  /// With a rim: whether the surface is open at a height, as seen from below.
  bool is_open_at(float z) const { return rim_->at(z, below_all_).above_tenth(); }

  /// Finds the solid parts of a stretch: takes samples at least a cell apart, and finds the layer where two of them differ by bisection.
  /// Between two samples that are plainly on the same side it takes none.
  /// @param set  set(layer, solid): from that layer upwards; first of all for the stretch's begin
  template <class Set>
  void decide(const RayStretch& stretch, Set set) const {
    const std::uint32_t length = stretch.end - stretch.begin;
    const std::uint32_t samples = std::clamp(length / field_->layers_in(1, grid_->layer_height_mm), 1U, kMostSamples);
    const auto layer_at = [&](std::uint32_t s) {
      return stretch.begin + static_cast<std::uint32_t>((2 * std::uint64_t{s} + 1) * length / (2 * samples));
    };
    std::array<Side, kMostSamples> found;
    const auto sample = [&](std::uint32_t s) { found[s] = side(layer_at(s), stretch.from_all_above); };
    for (const std::uint32_t s : {0U, samples / 2, samples - 1}) sample(s);
    for (const auto& [low, high] : {std::pair(0U, samples / 2), std::pair(samples / 2, samples - 1)}) {
      const bool plain = found[low].plain && found[high].plain && found[low].solid == found[high].solid;
      for (std::uint32_t s = low + 1; s < high; ++s) {
        if (plain) {
          found[s] = found[low];
        } else {
          sample(s);
        }
      }
    }
    set(stretch.begin, found[0].solid);
    for (std::uint32_t s = 1; s < samples; ++s) {
      const bool before = found[s - 1].solid;
      if (found[s].solid == before) continue;
      set(change(layer_at(s - 1), layer_at(s), before, stretch.from_all_above), found[s].solid);
    }
  }

 private:
  /// Samples of a stretch, at most. It has no hits, so only where the surface has holes can it change; a winding number costs 1 us.
  static constexpr std::uint32_t kMostSamples = 8;

  MeshRay(const MeshField& field, const PrintGrid& grid) : field_(&field), grid_(&grid) {}

  Side rim_side(float z, int above) const {
    WindingTurn turn = rim_->at(z, above);
    if (field_->base) {
      if (z < *field_->base) return {false, true};
      // The mirrored surface seen from here is the surface seen from the mirror image of this place, below all of it.
      turn.add(rim_->at(2 * *field_->base - z, below_all_));
    }
    if (!turn.is_near_half()) return {turn.above_half(), true};
    RimLean lean;
    rim_->add_lean(z, lean);
    if (field_->base) rim_->add_lean(2 * *field_->base - z, lean);
    return {turn.above_half(lean), false};
  }

  /// The first layer above `low` that is not as there.
  std::uint32_t change(std::uint32_t low, std::uint32_t high, bool at_low, int above) const {
    while (high - low > 1) {
      const std::uint32_t middle = low + (high - low) / 2;
      (inside(middle, above) == at_low ? low : high) = middle;
    }
    return high;
  }

  const MeshField* field_;
  const PrintGrid* grid_;
  std::optional<RimWinding> rim_;
  float x_ = 0, y_ = 0;
  int below_all_ = 0;  ///< the winding number below the mesh, by its hits
};

}  // namespace plumbline::inline slicer
