#pragma once
/// A job file as the child has read it. As in ScanAnswer, no byte has an invalid value, and none can be trusted.

#include <array>
#include <cstdint>

#include "firmware/settings/print_fields.hpp"
#include "firmware/settings/support_choice.hpp"
#include "slicer/reader/scan_sources.hpp"

namespace plumbline::firmware {

/// The fields of a StickJob.
struct JobAnswer {
  std::array<std::array<char, 256>, kMostScans> scan{};
  std::uint32_t scans = 0;  ///< how many
  std::array<char, 64> profile{};
  std::uint32_t units = 0;  ///< a Units
  std::uint32_t as = 0;     ///< a ReadAs
  std::uint32_t base = 0;   ///< a BaseChoice
  std::uint32_t fit = 0;
  std::uint32_t keep_all = 0;
  std::uint32_t side = 0;  ///< a Side, if size_mm is not 0
  double size_mm = 0;
  std::uint32_t orient = 0;
  std::uint32_t keep_clean = 0;  ///< a CleanSide
  std::uint32_t floor = 0;       ///< a FloorChoice::Kind
  double floor_height = 0;
  double scale = 1;
  std::array<double, 3> rotate_deg{};
  double layer_height = 0;
  PassedValues values;
  PassedSupports supports;
};

}  // namespace plumbline::firmware
