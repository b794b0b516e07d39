#pragma once
/// Writes the picture of where the checks of the masks have found something.

#include <string>

#include "firmware/pictures/issue_picture.hpp"
#include "firmware/pictures/mask_decoder.hpp"

namespace plumbline::firmware {

struct CheckedMasks {
  std::string name;  ///< of the scan or stack
  PrintGrid grid;
  StackFindings findings;
  GreyShare grey = {};  ///< of an archive
};

/// @param path  empty: nothing is written, nor if there is no issue
[[nodiscard]] Status write_issues_file(const std::string& path, const CheckedMasks& masks, MaskOf mask, Arena& arena);
[[nodiscard]] Status write_issues_file(const std::string& path, const CheckedMasks& masks, const RRep& rrep,
                                       const Supports& supports, Arena& arena);

}  // namespace plumbline::firmware
