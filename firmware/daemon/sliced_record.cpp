#include "firmware/daemon/sliced_record.hpp"

#include <algorithm>

#include "firmware/print/plan/print_plan.hpp"
#include "slicer/core/words/plural.hpp"

namespace plumbline {

MaskExtent extent_of(const RRep& rrep) {
  MaskExtent extent;
  for (const std::uint32_t pixel : rrep.pixel) {
    const std::uint32_t row = pixel / rrep.grid.columns, column = pixel - row * rrep.grid.columns;
    extent.left = std::min(extent.left, column);
    extent.right = std::max(extent.right, column + 1);
    extent.top = std::min(extent.top, row);
    extent.bottom = std::max(extent.bottom, row + 1);
  }
  return extent;
}

Expected<SlicedRecord> sliced_record(const PrintGrid& grid, const MaskExtent& extent, const StackFindings& findings,
                                     const PrintProfile& profile, const MachineFile& machine) {
  const double layer_height = double{grid.layer_height_mm};
  const auto plan = plan_print(profile, machine, layer_height, grid.layers);
  PLUMBLINE_TRY(plan);
  SlicedRecord record;
  if (!extent.empty()) {
    record.width_mm = (extent.right - extent.left) * double{grid.pitch_x_mm};
    record.depth_mm = (extent.bottom - extent.top) * double{grid.pitch_y_mm};
  }
  record.layers = grid.layers;
  record.layer_height_mm = layer_height;
  record.height_mm = grid.layers * layer_height;
  record.resin_ml = resin_ml(findings.voxels, double{grid.pitch_x_mm}, double{grid.pitch_y_mm}, layer_height);
  record.time = std::chrono::duration_cast<std::chrono::seconds>(print_time(*plan));
  return record;
}

FixedText<160> sliced_line(const SlicedRecord& sliced) {
  FixedText<160> text;
  text.add("%.1f x %.1f x %.1f mm, %u layer%s, %.1f ml, %lld min", sliced.width_mm, sliced.depth_mm, sliced.height_mm,
           sliced.layers, plural_s(sliced.layers), sliced.resin_ml,
           static_cast<long long>((sliced.time.count() + 59) / 60));
  return text;
}

}  // namespace plumbline
