#pragma once
/// What `plumbline inspect` found, for people and for machines.

#include <optional>
#include <string>
#include <vector>

#include "firmware/io/json_writer.hpp"
#include "firmware/io/output_file.hpp"
#include "firmware/slice/coverage_preview.hpp"
#include "slicer/inspect.hpp"

namespace plumbline {

/// A scan on a printer or in a grid of its own.
struct ScanOutlook {
  std::string scan_name;                ///< title_of() its files
  std::vector<std::string> scan_names;  ///< of the files
  std::string printer_name;             ///< empty without a printer
  PlacementSettings placement;
  InspectReport scan;
  Units units = Units::kMillimetres;    ///< used
  Units guess = Units::kMillimetres;    ///< by the size alone
  Expected<Placement> placed;           ///< at the scale asked for, or why it does not fit
  std::optional<double> largest_scale;  ///< that the printer takes; none without a printer
  std::optional<ScanLook> look;         ///< none: no_look says why
  FixedText<512> no_look;
  Expected<MemoryPlan> plan;  ///< for the points of this scan
  std::size_t arena_bytes = 0;
  std::uint32_t threads = 1;

  double unit_mm() const { return millimetres_per(units); }
};

/// Works out what the rest of the job would make of an inspected scan. Names are the caller's to fill in.
/// @param arena_bytes  the budget
ScanOutlook make_outlook(const InspectReport& scan, const PlacementSettings& placement, std::size_t arena_bytes,
                         std::uint32_t threads);

/// @param print_time  how long printing takes, in words; empty: unknown
/// @param verbose     also spacing, noise, classes of points, and the memory of each stage
/// @retval ErrorCode::kCannotWrite
[[nodiscard]] Status write_outlook(OutputFile& out, const ScanOutlook& outlook, std::string_view print_time,
                                   bool verbose);

/// As one JSON object, lengths in mm but where a key says "scan_units".
void write_outlook(JsonWriter& json, const ScanOutlook& outlook);

}  // namespace plumbline
