#pragma once
/// The stored job: a header, JobFacts, R-Rep, supports, and a hash of all of it.

#include <cstdint>

#include "firmware/io/descriptor.hpp"
#include "firmware/print/store/job_facts.hpp"
#include "slicer/core/arena.hpp"
#include "slicer/rrep/rrep.hpp"
#include "slicer/supports/drawing/supports.hpp"

namespace plumbline {

struct StoredJob {
  JobFacts facts;
  RRep rrep;          ///< at the bottom of the arena
  Supports supports;  ///< at the bottom of the arena
  std::uint64_t hash = 0;
};

/// Takes nothing from the heap.
/// @param hash  that of what was written
/// @returns false: errno has the reason
[[nodiscard]] bool write_job(const Descriptor& file, const JobFacts& facts, const RRep& rrep, const Supports& supports,
                             std::uint64_t& hash);

/// @param path  for messages
/// @retval ErrorCode::kMalformed    the file is damaged or cut off
/// @retval ErrorCode::kUnsupported  another version of plumbline wrote it
/// @retval ErrorCode::kOutOfMemory, kCannotRead
[[nodiscard]] Expected<StoredJob> read_job(const Descriptor& file, const char* path, Arena& arena);

}  // namespace plumbline
