#pragma once
/// The messages between the firmware and the template process, over a SOCK_SEQPACKET socket. The scan's request and answer are not
/// among them: they are in the shared memory.
///
///   template -> firmware   ready, or why not
///   firmware -> template   start, with the files' descriptors      the template forks a child
///   firmware -> template   kill                                    the child is killed
///   template -> firmware   ended                                   once for each start, when no thread of the child is left

#include <cstdint>

namespace plumbline::firmware {

enum class ChildWord : std::uint32_t { kReady = 1, kNotReady = 2, kStart = 3, kKill = 4, kEnded = 5 };

struct ChildMessage {
  ChildWord word = ChildWord::kKill;
  std::int32_t status = 0;     ///< kEnded: as wait(2) gives it
  std::uint32_t landlock = 0;  ///< kReady: 1 if the kernel has it
  char reason[212] = {};       ///< kNotReady
};

}  // namespace plumbline::firmware
