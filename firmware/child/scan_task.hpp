#pragma once
/// What the slicing child does: the one place where bytes of a stick are read as a scan.

#include <cstdint>

#include "firmware/child/shared_memory.hpp"

namespace plumbline::firmware {

/// Starts the threads, gives up all system calls but reading, then slices MessagePage::request and leaves its answer.
void run_scan_task(SharedMemory& memory, std::uint32_t threads);

/// For tasks: the answer is an error.
void hand_back_error(const Error& error, ScanAnswer& answer);
/// The error of a task for which filter_system_calls() failed.
void refuse_without_filter(ScanAnswer& answer);

}  // namespace plumbline::firmware
