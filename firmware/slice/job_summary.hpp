#pragma once
/// The report of `plumbline slice` for people.

#include <string_view>

#include "firmware/io/output_file.hpp"
#include "firmware/slice/job_report.hpp"

namespace plumbline::firmware {

/// Size, layers, resin, printing time, what was not scanned, and the files to look at.
/// @param output      the job's folder
/// @param print_time  how long printing takes, in words; empty: unknown
/// @param verbose     also counts, and time and memory of each stage
/// @retval ErrorCode::kCannotWrite
[[nodiscard]] Status write_summary(OutputFile& out, const JobReport& report, const char* output,
                                   std::string_view print_time, bool verbose);

}  // namespace plumbline::firmware
