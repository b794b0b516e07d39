#pragma once

#include <cstddef>
#include <cstdint>

#include "firmware/io/text/fixed_text.hpp"
#include "firmware/print/job/plan_check.hpp"
#include "firmware/print/job/print_plan.hpp"
#include "hal/thermals.hpp"
#include "hal/units.hpp"

namespace plumbline::firmware {

/// The plan of a print, with the printer's limits and the job's facts that the checks and the print need.
struct PrintSettings {
  PrintPlan plan;
  PlanRun run;                    ///< of the plan
  Celsius lamp_resume, lamp_max;  ///< from the board file
  Celsius resin_min, resin_max;   ///< from the board file
  Celsius board_max;              ///< from the board file
  bool has_cover_switch = true;
  double tank_ml = 0;              ///< of a full tank
  double pixel_ml = 0;             ///< resin in one pixel of one layer
  double first_layer_more_ml = 0;  ///< resin that the first layer takes more than one of the usual height
  std::uint64_t cured_pixels = 0;  ///< of all masks together
  std::uint64_t first_layer_pixels = 0;
  Distance cure_depth;                               ///< at a normal layer's exposure
  Distance first_cure_depth;                         ///< at the first layer's
  std::size_t memory_needed = 0, memory_budget = 0;  ///< of the arena, bytes
  Sentence issues;                                   ///< issue_counts(); empty: a resumed print, checked before
  bool has_issues = false;

  /// Resin for the whole print.
  double needed_ml() const { return static_cast<double>(cured_pixels) * pixel_ml + first_layer_more_ml; }
};

}  // namespace plumbline::firmware
