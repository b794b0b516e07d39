#pragma once
/// The slicer from end to end: scan bytes in, R-Rep out.

#include "slicer/core/arena.hpp"
#include "slicer/core/byte_source.hpp"
#include "slicer/core/progress.hpp"
#include "slicer/reader/scan_sources.hpp"
#include "slicer/rrep/rrep.hpp"
#include "slicer/slice_report.hpp"
#include "slicer/slice_settings.hpp"

namespace plumbline::inline slicer {

/// Reads a scan and builds its R-Rep at the bottom of the arena. On return the top of the arena is as before, and after an
/// error the bottom is too.
/// @param sources  1 to kMostScans files of one frame, each read once from start to end, in this order
/// @param report   filled as far as it went, also on error
/// @retval ErrorCode::kOutOfMemory  before the scan is read where its header and the printer's grid show it; else by the stage
/// @retval ErrorCode::kDoesNotFit, kNoPoints, kNoSurface, kCancelled and all of read_scan()
[[nodiscard]] Expected<RRep> slice(ScanSources sources, const SliceSettings& settings, Arena& arena,
                                   ProgressSink* progress, SliceReport& report);
[[nodiscard]] inline Expected<RRep> slice(ByteSource& source, const SliceSettings& settings, Arena& arena,
                                          ProgressSink* progress, SliceReport& report) {
  ByteSource* const one[] = {&source};
  return slice(ScanSources(one), settings, arena, progress, report);
}

}  // namespace plumbline::inline slicer
