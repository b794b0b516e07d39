#pragma once
/// What the scanner did not see, for a warning before slicing.

#include <string>
#include <string_view>

#include "firmware/io/fixed_text.hpp"
#include "slicer/core/arena.hpp"
#include "slicer/core/error.hpp"
#include "slicer/rrep/confidence.hpp"
#include "slicer/rrep/rrep.hpp"
#include "slicer/slice_report.hpp"

namespace plumbline {

struct ScanLook {
  ConfidenceShares shares;
  bool on_base_plane = false;
  double outside = 0;  ///< share of the rays through the scan that meet no object, 0 to 1

  bool underside_unseen() const;
  /// unseen_sentence(), or what is wrong with a scan that encloses nothing; empty where all of the surface was scanned.
  FixedText<128> sentence() const;
};

/// @param rrep     coarse, of inspect(); `report` is its own, with a confidence map
/// @param name     of the scan, for the picture
/// @param picture  file for a picture of what the surface rests on; empty: none
/// @retval ErrorCode::kCannotWrite, kOutOfMemory
[[nodiscard]] Expected<ScanLook> look_at_coarse(const RRep& rrep, const SliceReport& report, std::string_view name,
                                                const std::string& picture, Arena& arena);

}  // namespace plumbline
