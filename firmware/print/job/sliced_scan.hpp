#pragma once
/// A scan sliced for a print: what the print needs of it, all of it in the arena.

#include <cstdint>
#include <optional>

#include "slicer/checks/stack_findings.hpp"
#include "slicer/core/arena.hpp"
#include "slicer/core/error.hpp"
#include "slicer/core/progress.hpp"
#include "slicer/rrep/point_proof.hpp"
#include "slicer/rrep/rrep.hpp"
#include "slicer/slicer.hpp"
#include "slicer/supports/support_finder.hpp"

namespace plumbline::firmware {

struct SlicedScan {
  RRep rrep;          ///< at the bottom of the arena
  Supports supports;  ///< above it; empty: none
  SupportCounts support_counts;
  std::uint64_t scan_hash = 0;       ///< of the files' bytes: HashingSources::hash()
  std::uint64_t support_pixels = 0;  ///< those that the supports add
  StackFindings findings;            ///< of its masks
  PointProof proof{};                ///< of its R-Rep
};

/// Slices a scan, finds its supports, and checks the masks.
/// @param settings  supports: valid by check_support_settings()
/// @param progress  may be null
/// @param report    filled as far as it went, also on error
/// @retval any error of slice() and find_supports()
/// @retval ErrorCode::kCancelled, kOutOfMemory
[[nodiscard]] Expected<SlicedScan> slice_for_print(ScanSources scan, const SliceSettings& settings, Arena& arena,
                                                   ProgressSink* progress, SliceReport& report);

}  // namespace plumbline::firmware
