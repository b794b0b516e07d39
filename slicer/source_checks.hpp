#pragma once
/// Checks of scans and meshes alike before they are placed: is the unit clear, and is the extent large enough to print?

#include <optional>

#include "slicer/core/error.hpp"
#include "slicer/core/numbers/vec.hpp"
#include "slicer/placement/placement.hpp"
#include "slicer/reader/scan_sources.hpp"

namespace plumbline::inline slicer {

/// Tests that files whose format fixes their unit share a frame only with others of that unit.
/// @param some_in_mm        some files are of such a format
/// @param some_in_any_unit  some are not
/// @retval ErrorCode::kBadSetting  both, and the others would be in another unit
[[nodiscard]] Status check_units(ScanSources sources, Units units, bool some_in_mm, bool some_in_any_unit);
/// The same once all files are read.
/// @returns the unit asked for, if it is ignored for them
/// @retval ErrorCode::kBadSetting  only some of the files are in mm whatever unit is asked for
[[nodiscard]] Expected<std::optional<Units>> check_units(ScanSources sources, Units units, const ScanSummaries& scans);

/// The settings with the unit that the format of the scan fixes, if it fixes one.
/// @param header  sum_of() the files
PlacementSettings heed_header(const PlacementSettings& settings, const ScanHeader& header);

/// @retval ErrorCode::kNoSurface  all points or corners lie at one place: names the files
[[nodiscard]] Status check_extent(const Box3d& bounds, ScanSources sources);

/// @param bounds  of the scan, rotated scan coordinates
/// @param header  sum_of() the files
/// @retval ErrorCode::kNoSurface  the object would be a speck: names the files, its size, and what to do
[[nodiscard]] Status check_no_speck(const Box3d& bounds, ScanSources sources, const PlacementSettings& settings,
                                    const ScanHeader& header);

/// The unit asked for, or the one that the extent suggests: that of the figure as it came, so that a turn never changes it.
/// @param bounds    of the scan as it stands, scan units
/// @param settings  of a scan: after heed_header()
Units units_of(const Box3d& bounds, const PlacementSettings& settings);

}  // namespace plumbline::inline slicer
