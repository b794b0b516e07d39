#pragma once
/// `plumbline doctor`: what is there of the printer that a board file describes, and what is not.

#include <span>
#include <string>

#include "firmware/cli/commands.hpp"
#include "firmware/io/output_file.hpp"
#include "firmware/machine/back_end.hpp"

namespace plumbline {

/// A line for each finding, with what to do below it, and a last one that says whether the printer would print.
[[nodiscard]] Status write_findings(OutputFile& out, const std::string& printer,
                                    std::span<const MachineFinding> findings);

/// The same as one JSON object.
[[nodiscard]] Status write_findings_json(OutputFile& out, const std::string& printer,
                                         std::span<const MachineFinding> findings);

/// Nothing is wrong: the printer would print.
bool prints(std::span<const MachineFinding> findings);

}  // namespace plumbline
