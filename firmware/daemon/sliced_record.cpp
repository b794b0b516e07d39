#include "firmware/daemon/sliced_record.hpp"

#include <algorithm>

#include "firmware/print/plan/print_plan.hpp"

namespace plumbline {

Expected<SlicedRecord> sliced_record(const SlicedScan& sliced, const PrintProfile& profile,
                                     const MachineFile& machine) {
  const PrintGrid& grid = sliced.rrep.grid;
  const double layer_height = double{grid.layer_height_mm};
  const auto plan = plan_print(profile, machine, layer_height, grid.layers);
  PLUMBLINE_TRY(plan);
  std::uint32_t left = grid.columns, right = 0, top = grid.rows, bottom = 0;
  for (const std::uint32_t pixel : sliced.rrep.pixel) {
    const std::uint32_t row = pixel / grid.columns, column = pixel - row * grid.columns;
    left = std::min(left, column);
    right = std::max(right, column + 1);
    top = std::min(top, row);
    bottom = std::max(bottom, row + 1);
  }
  SlicedRecord record;
  if (left < right) {
    record.width_mm = (right - left) * double{grid.pitch_x_mm};
    record.depth_mm = (bottom - top) * double{grid.pitch_y_mm};
  }
  record.layers = grid.layers;
  record.layer_height_mm = layer_height;
  record.height_mm = grid.layers * layer_height;
  record.resin_ml = resin_ml(sliced.findings.voxels, double{grid.pitch_x_mm}, double{grid.pitch_y_mm}, layer_height);
  record.time = std::chrono::duration_cast<std::chrono::seconds>(print_time(*plan));
  return record;
}

FixedText<160> sliced_line(const SlicedRecord& sliced) {
  FixedText<160> text;
  text.add("%.1f x %.1f x %.1f mm, %u layers, %.1f ml, %lld min", sliced.width_mm, sliced.depth_mm, sliced.height_mm,
           sliced.layers, sliced.resin_ml, static_cast<long long>((sliced.time.count() + 59) / 60));
  return text;
}

}  // namespace plumbline
