#pragma once
/// The report of a print, for people and for programs.

#include <optional>
#include <span>
#include <string>

#include "firmware/io/output_file.hpp"
#include "firmware/io/text/json_writer.hpp"
#include "firmware/machine/part_figures.hpp"
#include "firmware/machine/step_figures.hpp"
#include "firmware/print/print_session.hpp"

namespace plumbline::firmware {

/// The input of a report.
struct PrintOutcome {
  const PrintReport& report;
  const PrintSession& session;
  const PrintProfile& profile;
  std::span<const std::string> objections;  ///< of a simulated printer
  std::optional<StepFigures> steps;         ///< of a real one, in this print
  std::optional<PartFigures> part;          ///< of a simulated one
};

/// The report for people: how far the print came, what went wrong and what to do, time, resin, warnings, files to look at.
/// @param look_at  files, for the last line; empty: none
/// @param verbose  also doses, masks, steps and the slowest layer
/// @retval ErrorCode::kCannotWrite
[[nodiscard]] Status write_print_summary(OutputFile& out, const PrintOutcome& outcome, std::string_view look_at,
                                         bool verbose);

/// One JSON object; firmware/README.md explains its keys.
void write_print_report(JsonWriter& json, const PrintOutcome& outcome);

}  // namespace plumbline::firmware
