#pragma once
/// The picture of where the checks of the masks have found something.

#include <array>
#include <cstddef>
#include <cstdint>
#include <span>
#include <string_view>

#include "firmware/pictures/job_pictures.hpp"
#include "firmware/pictures/png.hpp"
#include "slicer/checks/stack_findings.hpp"
#include "slicer/core/arena.hpp"
#include "slicer/core/error.hpp"
#include "slicer/core/function_ref.hpp"
#include "slicer/core/print_grid.hpp"
#include "slicer/rrep/rrep.hpp"
#include "slicer/supports/drawing/supports.hpp"

namespace plumbline::firmware::inline pictures {

/// The mask of a layer, valid until the next call.
using MaskOf = FunctionRef<Expected<ConstBitImage>(std::uint32_t layer)>;

/// The issues that a picture shows: the largest of each kind, then the next ones, but no empty layers. At most kMostShown, by layer.
struct ShownIssues {
  static constexpr std::size_t kMostShown = 6;
  std::array<Issue, kMostShown> issues;
  std::size_t count = 0;

  explicit ShownIssues(const StackFindings& findings);
};

/// Draws a part of the mask round each issue: white pixels, those of the layer below in grey, and the issue in red.
/// @param name   of the scan
/// @param masks  called for each layer that is shown and the one below it, in ascending order
/// @param arena  two images of the grid and the regions of one are taken from its top and released
/// @param rgb    kPageBytes of the caller, row after row from the top; overwritten
/// @retval ErrorCode::kOutOfMemory, and any error of `masks`
[[nodiscard]] Status draw_issues(const StackFindings& findings, const PrintGrid& grid, std::string_view name,
                                 MaskOf masks, Arena& arena, std::span<std::uint8_t> rgb);

/// The same for the masks of an R-Rep, which are made anew, beside an overview: the print from the front with the number of each part
/// at its place.
/// @param arena  a MaskStream is taken from its bottom and released, too, and before that what a preview takes
[[nodiscard]] Status draw_issues(const StackFindings& findings, const RRep& rrep, const Supports& supports,
                                 std::string_view name, Arena& arena, std::span<std::uint8_t> rgb);

/// Draws the same tiles without texts, small enough to be kept for as long as the job lasts. There is no picture if there is nothing to
/// show, and none after an error.
/// @param masks  called for each layer that is shown and the one below it, in ascending order
/// @param arena  two images of the grid and the regions of one are taken from its top and released
/// @retval ErrorCode::kOutOfMemory, and any error of `masks`
[[nodiscard]] Status draw_issues_picture(const StackFindings& findings, const PrintGrid& grid, MaskOf masks,
                                         Arena& arena, IssuesPicture& picture);

/// The same for the masks of an R-Rep, which are made anew.
/// @param arena  a MaskStream is taken from its bottom and released, too
[[nodiscard]] Status draw_issues_picture(const StackFindings& findings, const RRep& rrep, const Supports& supports,
                                         Arena& arena, IssuesPicture& picture);

}  // namespace plumbline::firmware::inline pictures
