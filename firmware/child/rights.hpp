#pragma once
/// What a process gives up, for good, before it reads a scan.

#include <cstdint>

#include "slicer/core/error.hpp"

namespace plumbline {

/// Closes all descriptors but `kept`, which becomes kKeptDescriptor. Gives up every capability and every way to gain one, all access to
/// files and, where the kernel has it, to the network and to other processes (Landlock). Nobody may debug the process or see its core,
/// and the kernel ends it first when memory runs out. Its children inherit all of this.
/// @pre the process has one thread
/// @param kept  a descriptor
/// @returns whether the kernel has Landlock
/// @retval ErrorCode::kUnsupported  the kernel lacks something else that is needed
[[nodiscard]] Expected<bool> give_up_rights(int kept);
inline constexpr int kKeptDescriptor = 3;

/// After this call the threads of the process can only compute, wait for each other, read the descriptors they have, and exit. A request
/// for memory fails. Any other system call kills the process (SIGSYS).
/// @returns false: the kernel has no seccomp filters
[[nodiscard]] bool filter_system_calls();

}  // namespace plumbline
