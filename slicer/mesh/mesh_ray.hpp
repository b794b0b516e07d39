#pragma once
/// The winding number of a mesh along one ray.

#include <algorithm>
#include <cmath>
#include <cstdint>

#include "slicer/core/bit_image.hpp"
#include "slicer/core/print_grid.hpp"
#include "slicer/implicit/winding_number.hpp"
#include "slicer/mesh/ray_solids.hpp"

namespace plumbline {

/// The winding number of a mesh that is not closed.
struct MeshField {
  const WindingTree* winding = nullptr;
  float cell = 0;     ///< mm: nearer to the surface the number is not trusted
  BitImage doubtful;  ///< one pixel a tile: where the hits miss solid parts. Set by find_doubtful()
  std::uint32_t first_column = 0, end_column = 0;  ///< tiles that the object's box covers
  std::uint32_t first_row = 0, end_row = 0;

  /// Layers in a number of cells, at least 1.
  std::uint32_t layers_in(float cells, float layer_height) const {
    return static_cast<std::uint32_t>(std::clamp(cells * cell / layer_height, 1.0F, 65535.0F));
  }
};

class MeshRay {
 public:
  MeshRay(const MeshField& field, const PrintGrid& grid, std::uint32_t column, std::uint32_t row)
      : field_(field),
        layer_height_(grid.layer_height_mm),
        x_((static_cast<float>(column) + 0.5F) * grid.pitch_x_mm),
        y_((static_cast<float>(row) + 0.5F) * grid.pitch_y_mm) {}

  bool inside(std::uint32_t layer) const {
    // Most places are so plainly inside or outside that a rough number tells.
    constexpr float kPlain = WindingLean::kMost + WindingTree::kRough;
    const Vec3f place(x_, y_, (static_cast<float>(layer) + 0.5F) * layer_height_);
    const float rough = field_.winding->rough(place);
    if (std::abs(rough - WindingTree::kSurface) > kPlain) return rough > WindingTree::kSurface;
    return field_.winding->inside(place);
  }
  /// Finds the solid parts of a stretch by samples a cell apart or more, and the layer where they change by bisection.
  /// @param set  set(layer, solid): from that layer upwards; first of all for the stretch's begin
  template <class Set>
  void decide(const RayStretch& stretch, Set set) const {
    const std::uint32_t length = stretch.end - stretch.begin;
    const std::uint32_t samples = std::clamp(length / field_.layers_in(1, layer_height_), 1U, kMostSamples);
    bool before = false;
    std::uint32_t last = stretch.begin;
    for (std::uint32_t s = 0; s < samples; ++s) {
      const auto layer =
          stretch.begin + static_cast<std::uint32_t>((2 * std::uint64_t{s} + 1) * length / (2 * samples));
      const bool solid = inside(layer);
      if (s == 0) {
        set(stretch.begin, solid);
      } else if (solid != before) {
        set(change(last, layer, before), solid);
      }
      before = solid;
      last = layer;
    }
  }

 private:
  /// Samples of a stretch, at most. It has no hits, so only where the surface has holes can it change; a winding number costs 1 us.
  static constexpr std::uint32_t kMostSamples = 8;

  /// The first layer above `low` that is not as there.
  std::uint32_t change(std::uint32_t low, std::uint32_t high, bool at_low) const {
    while (high - low > 1) {
      const std::uint32_t middle = low + (high - low) / 2;
      (inside(middle) == at_low ? low : high) = middle;
    }
    return high;
  }

  const MeshField& field_;
  float layer_height_;
  float x_, y_;
};

}  // namespace plumbline
