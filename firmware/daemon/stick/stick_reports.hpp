#pragma once
/// Writes the reports of the last prints onto a stick that asks for them.

#include <cstddef>
#include <string_view>

#include "firmware/print/job/kept_prints.hpp"
#include "hal/stick_port.hpp"
#include "slicer/core/error.hpp"

namespace plumbline::firmware {

struct StoredReports {
  bool asked = false;     ///< the stick has the folder kReportFolder
  std::size_t files = 0;  ///< written now
};

/// Gives a stick with a folder `plumbline-reports` what it lacks of the last prints: PRINTER-20261127-0012.json and .png, by the day on
/// which the print ended (UTC) and its number. Takes nothing from the heap.
/// @param printer  its name in the board file
/// @pre the stick is not mounted
/// @retval the errors of StickPort::mount() and store(), and of KeptPrints::find(); what has been written by then stays
[[nodiscard]] Expected<StoredReports> store_reports(StickPort& stick, const KeptPrints& prints,
                                                    std::string_view printer);

}  // namespace plumbline::firmware
