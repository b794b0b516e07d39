#pragma once
/// The checks that need no regions: areas, the panel's edge, gaps, height.

#include <cstdint>
#include <span>

#include "slicer/checks/check_limits.hpp"
#include "slicer/checks/overhangs.hpp"
#include "slicer/checks/stack_findings.hpp"
#include "slicer/core/bit_image.hpp"
#include "slicer/core/print_grid.hpp"

namespace plumbline::inline slicer {

/// What a layer's mask has.
struct SeenLayer {
  RegionBox box;  ///< round all white pixels
  std::uint64_t pixels = 0;
};

class LayerMeasures {
 public:
  LayerMeasures(const PrintGrid& grid, const CheckLimits& limits) : scale_(grid), limits_(limits) {}

  /// Takes the layers one after the other, from 0.
  void next(ConstBitImage mask, const SeenLayer& seen, StackFindings& findings);
  /// After the last one.
  void finish(StackFindings& findings);

 private:
  void check_areas(const SeenLayer& seen, StackFindings& findings);
  void check_bounds(ConstBitImage mask, const RegionBox& box);
  void end_gap(StackFindings& findings);

  IssueScale scale_;
  CheckLimits limits_;
  std::uint32_t layer_ = 0;
  std::uint64_t pixels_below_ = 0;
  std::uint32_t empty_layers_ = 0;  ///< in a row, up to the newest one
  Issue bound_, peel_, height_;     ///< of all layers so far
};

/// White pixels of a row in columns [begin, end).
std::uint64_t count_in(std::span<const std::uint64_t> line, std::uint32_t begin, std::uint32_t end);

}  // namespace plumbline::inline slicer
