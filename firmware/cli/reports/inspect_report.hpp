#pragma once
/// The report of `plumbline inspect`, for people and as JSON.

#include <optional>
#include <string>
#include <vector>

#include "firmware/io/output_file.hpp"
#include "firmware/io/text/json_writer.hpp"
#include "firmware/slice/coverage_preview.hpp"
#include "slicer/checks/stack_findings.hpp"
#include "slicer/inspect.hpp"
#include "slicer/plan/memory_plan.hpp"

namespace plumbline::firmware {

/// The expected result of slicing a scan, on a printer or in a grid that fits the object.
struct ScanOutlook {
  std::string scan_name;                ///< title_of() its files
  std::vector<std::string> scan_names;  ///< of the files
  std::string printer_name;             ///< empty without a printer
  PlacementSettings placement;
  InspectReport scan;
  Units guess = Units::kMillimetres;        ///< the unit that its size suggests
  std::optional<double> largest_scale;      ///< that fits the printer; none without a printer
  std::optional<StackFindings> findings;    ///< of the coarse masks, without supports; none: there are none
  PrintGrid coarse_grid;                    ///< of those masks
  std::optional<CoveragePreview> coverage;  ///< none: scan.sliced has the reason
  Expected<MemoryPlan> plan;                ///< for the points of this scan
  std::size_t arena_bytes = 0;
  std::uint32_t threads = 1;

  double unit_mm() const { return millimetres_per(scan.units); }
  /// Scale of the print: the requested one, or with `fit` the largest that fits the printer.
  double scale() const {
    return scan.placement ? scan.placement->scale / unit_mm() : scale_of(scan.came * unit_mm(), placement);
  }
  double mm(ScanLength length) const { return static_cast<double>(length.value) * unit_mm(); }
};

/// Plans the rest of the job for an inspected scan. The caller fills in the names.
/// @param arena_bytes  the budget
ScanOutlook make_outlook(const InspectReport& scan, const PlacementSettings& placement, std::size_t arena_bytes,
                         std::uint32_t threads);

/// @param print_time  how long printing takes, in words; empty: unknown
/// @param verbose     also spacing, noise, classes of points, and the memory of each stage
/// @retval ErrorCode::kCannotWrite
[[nodiscard]] Status write_outlook(OutputFile& out, const ScanOutlook& outlook, std::string_view print_time,
                                   bool verbose);

/// As one JSON object, with lengths in mm unless a key says "scan_units".
void write_outlook(JsonWriter& json, const ScanOutlook& outlook);

}  // namespace plumbline::firmware
