#pragma once
/// The child's work on an archive of a sliced print.

#include <cstdint>

#include "firmware/child/shared_memory.hpp"

namespace plumbline::firmware {

/// Gives up all system calls but reading, does what MessagePage::request asks of the archive, and leaves its answer.
/// @param threads  that draw the preview
void run_archive_task(SharedMemory& memory, std::uint32_t threads);

}  // namespace plumbline::firmware
