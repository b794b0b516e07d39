#pragma once
/// What a process gives up, for good, before it reads a scan.

#include <cstdint>
#include <span>

#include "slicer/core/error.hpp"

namespace plumbline::firmware {

/// Gives up every capability and every way to gain one, all access to files but those that are open and, where the kernel has it, to the
/// network and to other processes (Landlock). Nobody may debug the process or see its core. Its children inherit all of this.
/// @pre the process has one thread
/// @returns whether the kernel has Landlock
/// @retval ErrorCode::kUnsupported  the kernel lacks something else that is needed
[[nodiscard]] Expected<bool> give_up_files();

/// Closes all descriptors but `kept`, which becomes kKeptDescriptor, then give_up_files(). The kernel ends the process first when memory
/// runs out.
/// @param kept  a descriptor
/// @returns, @pre, @retval as give_up_files()
[[nodiscard]] Expected<bool> give_up_rights(int kept);
/// Above those of the scan's files, which have 0, 1, ...
inline constexpr int kKeptDescriptor = 32;

/// After this call the threads of the process can only compute, wait for each other, read the descriptors they have, and exit. A request
/// for memory fails. Any other system call kills the process (SIGSYS). The filter is made on the heap before it holds.
/// @returns false: the kernel has no seccomp filters
[[nodiscard]] bool filter_system_calls();

/// A system call that a process may still make.
struct CallRule {
  /// A condition for the low 32 bits of an argument: its bits of `mask` are `value`.
  struct Condition {
    int argument = -1;  ///< 0 to 5; -1: none
    std::uint32_t mask = 0, value = 0;
  };
  const char* call;  ///< its name; left out where the machine has no such call
  Condition when = {};
};
/// After this call the threads of the process can make only these system calls. Any other fails with EPERM.
/// @returns false: the kernel has no seccomp filters
[[nodiscard]] bool filter_system_calls(std::span<const CallRule> allowed);

}  // namespace plumbline::firmware
