#pragma once
/// The last lines of `plumbline slice`, for people.

#include "firmware/io/output_file.hpp"
#include "firmware/slice/job_report.hpp"

namespace plumbline {

/// A dozen lines with what was read, decided and written, a table of the arena by stage, and where to look.
/// @param output  the job's folder
/// @retval ErrorCode::kCannotWrite
[[nodiscard]] Status write_summary(OutputFile& out, const JobReport& report, const char* output);

}  // namespace plumbline
