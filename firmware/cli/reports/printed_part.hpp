#pragma once
/// Writes the part that a simulated printer has made: its layers and its picture.

#include "firmware/machine/back_end.hpp"
#include "firmware/print/print_session.hpp"
#include "firmware/print/truth/true_surface.hpp"
#include "firmware/slice/job_directory.hpp"
#include "slicer/core/arena.hpp"

namespace plumbline::firmware {

/// Checks, before the print, that the folder has room for the part, by the masks' sizes.
/// @pre the session is ready to print
/// @retval ErrorCode::kCannotWrite  it has not
/// @retval the errors of PrintSession::mask() and PngEncoder
[[nodiscard]] Status check_room_for_part(const JobDirectory& directory, PrintSession& session);

/// Writes what was cured as `plumbline slice` writes its layers: layers, preview.png, manifest.json if this session sliced the
/// scan, and comparison.png, which shows the part beside what was to be printed, and how far it deviates. For the desktop: uses the heap.
/// @param measured  null: the deviation is not known
/// @param arena     its free part is used for the picture
/// @retval the errors of JobDirectory and PngEncoder
[[nodiscard]] Status write_printed_part(JobDirectory& directory, const Witness& witness, PrintSession& session,
                                        const MeasuredSurface* measured, Arena& arena);

}  // namespace plumbline::firmware
