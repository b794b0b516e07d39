#pragma once
/// The read-only basics of OctoPrint's REST API (docs.octoprint.org/en/master/api, "version", "job", "printer"), so that the programs of
/// print farms see the printer.

#include <string_view>

#include "firmware/io/text/text_sink.hpp"
#include "slicer/core/error.hpp"

namespace plumbline::firmware::inline page {

/// @param state_line  the printer's state as its socket sends it; empty: the printer's daemon does not run
/// @retval ErrorCode::kCannotWrite  `out` is full
[[nodiscard]] Status write_octoprint_version(TextSink& out);
[[nodiscard]] Status write_octoprint_job(TextSink& out, std::string_view state_line);
[[nodiscard]] Status write_octoprint_printer(TextSink& out, std::string_view state_line);

}  // namespace plumbline::firmware::inline page
