#pragma once
/// What the daemon's child does: it reads job files too, for they are as foreign as scans.

#include "firmware/child/scan_answer.hpp"
#include "firmware/child/shared_memory.hpp"
#include "firmware/daemon/stick/stick_job.hpp"

namespace plumbline::firmware {

/// A ChildTask: reads a job file or an archive if that is what is asked for, else run_scan_task().
void run_stick_task(SharedMemory& memory, std::uint32_t threads);

/// @param answer  a copy of what the child left
/// @retval ErrorCode::kBadSetting  the answer does not add up; otherwise the child's own error, if it can be a job file's
[[nodiscard]] Expected<StickJob> check_job_answer(const ScanAnswer& answer);

}  // namespace plumbline::firmware
