#pragma once
/// What the scanner did not see, found by a coarse slice.

#include <string>
#include <string_view>

#include "firmware/io/text/fixed_text.hpp"
#include "slicer/core/arena.hpp"
#include "slicer/core/error.hpp"
#include "slicer/rrep/confidence.hpp"
#include "slicer/rrep/rrep.hpp"
#include "slicer/slice_report.hpp"

namespace plumbline::firmware {

struct CoveragePreview {
  ConfidenceShares shares;
  bool on_base_plane = false;
  double outside = 0;  ///< share of the rays through the scan that meet no solid, 0 to 1

  bool underside_unseen() const;
  /// unseen_sentence(), or what is wrong with a scan that encloses nothing. Empty if all of the surface was scanned.
  FixedText<128> sentence() const;
};

/// Sums up a coarse slice, and draws it if asked to.
/// @param rrep     the coarse R-Rep of inspect(); `report` belongs to it and has a confidence map
/// @param name     of the scan, for the picture
/// @param picture  file for a picture of what the surface rests on; empty: none
/// @retval ErrorCode::kCannotWrite, kOutOfMemory
[[nodiscard]] Expected<CoveragePreview> preview_coverage(const RRep& rrep, const SliceReport& report,
                                                         std::string_view name, const std::string& picture,
                                                         Arena& arena);

}  // namespace plumbline::firmware
