#pragma once
/// Slices a scan in its own arena, and gives the result by voxel.

#include <cstdint>
#include <string>
#include <utility>
#include <vector>

#include "slicer/layers/layer_stream.hpp"
#include "slicer/slicer.hpp"
#include "tests/slicer/reader/scan_fixture.hpp"
#include "tests/slicer/support/arena_block.hpp"
#include "tests/slicer/support/pixels.hpp"
#include "tests/slicer/support/scan_cloud.hpp"

namespace plumbline::testing {

class Slicing {
 public:
  Slicing(ScanSources sources, const SliceSettings& settings, std::size_t arena_bytes)
      : arena_(arena_bytes), rrep_(value_of(slice(sources, settings, *arena_, nullptr, report_))) {}
  Slicing(ByteSource& source, const SliceSettings& settings, std::size_t arena_bytes)
      : arena_(arena_bytes), rrep_(value_of(slice(source, settings, *arena_, nullptr, report_))) {}
  Slicing(const std::string& bytes, const SliceSettings& settings, std::size_t arena_bytes)
      : Slicing(MemorySource(bytes, "test.ply"), settings, arena_bytes) {}
  Slicing(MemorySource source, const SliceSettings& settings, std::size_t arena_bytes)
      : Slicing(static_cast<ByteSource&>(source), settings, arena_bytes) {}

  const RRep& rrep() const { return rrep_; }
  const SliceReport& report() const { return report_; }
  const PrintGrid& grid() const { return rrep_.grid; }
  Arena& arena() { return *arena_; }
  std::uint64_t rays(RayDecision decision) const { return report_.rays.decided[static_cast<std::size_t>(decision)]; }

  /// Calls visit(layer, section) for every layer, before opening and closing.
  template <class Visit>
  void for_each_section(Visit visit) const {
    OwnedImage section(grid().columns, grid().rows);
    const CrossingPacking packing(grid());
    for (std::uint32_t k = 0; k < grid().layers; ++k) {
      for (std::uint32_t i = rrep_.first[k]; i < rrep_.first[k + 1]; ++i) {
        const std::uint32_t pixel = packing.pixel(rrep_.packed[i]), c = pixel % grid().columns;
        section.view().words()[std::size_t{pixel / grid().columns} * section.view().stride() + c / 64] ^=
            std::uint64_t{1} << (c % 64);
      }
      visit(k, ConstBitImage(section.view()));
    }
  }

  /// Volume of the sections, mm^3.
  double volume() const {
    std::uint64_t voxels = 0;
    for_each_section([&](std::uint32_t, ConstBitImage section) { voxels += section.count(); });
    return static_cast<double>(voxels) * static_cast<double>(grid().pitch_x_mm) *
           static_cast<double>(grid().pitch_y_mm) * static_cast<double>(grid().layer_height_mm);
  }

  /// Scan coordinates of the middle of a voxel.
  Vec3d middle_of(std::uint32_t column, std::uint32_t row, std::uint32_t layer) const {
    const Vec3d print((column + 0.5) * static_cast<double>(grid().pitch_x_mm),
                      (row + 0.5) * static_cast<double>(grid().pitch_y_mm),
                      (layer + 0.5) * static_cast<double>(grid().layer_height_mm));
    const Placement& p = report_.placement;
    return p.rotation.transpose() * (print - p.shift) / p.scale;
  }

  /// Voxels on the wrong side of the surface that are farther from it than `tolerance`, scan units.
  /// @param distance  signed distance from the surface, negative inside
  template <class Distance>
  std::uint64_t wrong_voxels(Distance distance, double tolerance) const {
    std::uint64_t wrong = 0;
    for_each_section([&](std::uint32_t k, ConstBitImage section) {
      for (std::uint32_t r = 0; r < grid().rows; ++r) {
        for (std::uint32_t c = 0; c < grid().columns; ++c) {
          const double d = distance(middle_of(c, r, k));
          wrong += std::abs(d) > tolerance && (d < 0) != section.at(c, r) ? 1 : 0;
        }
      }
    });
    return wrong;
  }

  /// Crossings of each ray over all layers, by pixel.
  std::vector<std::uint32_t> crossings_by_ray() const {
    std::vector<std::uint32_t> count(std::size_t{grid().columns} * grid().rows, 0);
    const CrossingPacking packing(grid());
    for (const std::uint32_t packed : rrep_.packed) ++count[packing.pixel(packed)];
    return count;
  }

 private:
  ArenaBlock arena_;
  SliceReport report_;
  RRep rrep_;
};

inline SliceSettings settings_with_pitch(float pitch_mm) {
  SliceSettings settings;
  settings.placement.pixel_pitch_mm = pitch_mm;
  settings.placement.layer_height_mm = pitch_mm;
  return settings;
}

}  // namespace plumbline::testing
