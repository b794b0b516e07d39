#pragma once
/// Checks the answer of the slicing child before anything uses it.

#include <array>
#include <span>

#include "firmware/child/scan_answer.hpp"
#include "firmware/child/scan_request.hpp"
#include "firmware/io/text/fixed_text.hpp"
#include "firmware/print/job/sliced_archive.hpp"
#include "firmware/print/job/sliced_scan.hpp"
#include "slicer/core/arena.hpp"
#include "slicer/core/grey_runs.hpp"

namespace plumbline::firmware {

struct CheckedAnswer {
  SlicedScan sliced;
  std::array<Sentence, ScanAnswer::kMostRemarks> remark;
  std::array<Told, ScanAnswer::kMostRemarks> remark_told;
  std::size_t remarks = 0;
};

/// What to do about a file that makes the child fail.
inline constexpr const char* kExportAgain =
    "Export it again, as PLY, PCD, OBJ, XYZ or STL, and report this file to plumbline's maintainers";

/// Checks every number, place, crossing and support, so that no mask reads or draws outside its image. That the crossings are those of
/// the scan is not checked: whoever makes the scan decides what is printed anyway.
/// @pre the child has ended, all its threads included
/// @param answer  a copy of what it left
/// @param arena   empty, over the memory that the child worked in. Takes the child's result at its bottom
/// @retval ErrorCode::kMalformed  the answer does not add up; otherwise the child's own error, if it can be a scan's
[[nodiscard]] Expected<CheckedAnswer> check_answer(const ScanAnswer& answer, const ScanRequest& request, Arena& arena);

/// The same for the answer about an archive. Whether a layer is there, and is the one that was checked, shows when it is decoded.
/// @param arena  as above; takes the layers at its bottom
[[nodiscard]] Expected<SlicedArchive> check_archive_answer(const ScanAnswer& answer, const ScanRequest& request,
                                                           Arena& arena);

/// The grey pixels of a layer.
/// @param runs   where the child was to leave them
/// @param count  how many it says there are
/// @param greys  of an image of `columns` x `rows`; becomes them
/// @retval ErrorCode::kMalformed  there can't be so many, one has no pixel, lies outside the image or across rows, is out of order, or is
///                                black or white
[[nodiscard]] Status take_checked_greys(std::span<const GreyRun> runs, std::uint64_t count, std::uint32_t columns,
                                        std::uint32_t rows, GreyRuns& greys);

/// The same for the ways up that it proposes.
/// @retval ErrorCode::kMalformed  a number is none, or can't be; otherwise the child's own error, if it can be a scan's
[[nodiscard]] Expected<Proposals> check_proposals(const ScanAnswer& answer);

/// The error of a child that refused its file.
/// @param possible  what such a file can cause; the child may claim nothing else
[[nodiscard]] tl::unexpected<Error> child_error(const ScanAnswer& answer, std::span<const ErrorCode> possible);

}  // namespace plumbline::firmware
