#pragma once
/// What a scan has not seen, told before it is sliced.

#include <string>

#include "firmware/io/fixed_text.hpp"
#include "slicer/core/arena.hpp"
#include "slicer/core/error.hpp"
#include "slicer/reader/scan_sources.hpp"
#include "slicer/rrep/confidence.hpp"
#include "slicer/slicer.hpp"

namespace plumbline {

/// Layers of the longest side that a look is made with.
inline constexpr double kLookLayers = 160;

struct ScanLook {
  ConfidenceShares shares;
  bool on_base_plane = false;
  double outside = 0;  ///< share of the rays through the scan that meet no object, 0 to 1

  bool underside_unseen() const;
  /// unseen_sentence(), or what is wrong with a scan that encloses nothing; empty where all of the surface was scanned.
  FixedText<128> sentence() const;
};

/// Slices the scan coarsely, which takes as long as reading it and a little more, and draws what it rests on.
/// @param sources     once more from the start
/// @param settings    as for slice(); grid, printer and scale are of no interest
/// @param longest_mm  side of the object at scale 1, above 0
/// @param picture     file for the picture; empty: none
/// @param arena       as before when it returns
/// @retval ErrorCode::kCannotWrite, and any error of slice()
[[nodiscard]] Expected<ScanLook> look_at_scan(ScanSources sources, const SliceSettings& settings, double longest_mm,
                                              const std::string& picture, Arena& arena, ProgressSink* progress);

}  // namespace plumbline
