#pragma once
/// `plumbline doctor`: which parts of the printer in a board file were found, and which are missing.

#include <span>
#include <string>

#include "firmware/cli/commands.hpp"
#include "firmware/io/output_file.hpp"
#include "firmware/machine/back_end.hpp"

namespace plumbline::firmware {

/// Writes a line for each finding with advice below it, and a last line that says whether the printer would print.
[[nodiscard]] Status write_findings(OutputFile& out, const std::string& printer,
                                    std::span<const MachineFinding> findings);

/// The same as one JSON object.
[[nodiscard]] Status write_findings_json(OutputFile& out, const std::string& printer,
                                         std::span<const MachineFinding> findings);

/// Whether nothing is wrong, so that the printer would print.
bool prints(std::span<const MachineFinding> findings);

}  // namespace plumbline::firmware
