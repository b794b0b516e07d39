#pragma once
/// The stored job: a header, JobFacts, R-Rep and supports or the layers of an archive, and a hash of all of it.

#include <cstdint>
#include <span>

#include "firmware/archive/layer_archive.hpp"
#include "firmware/io/descriptor.hpp"
#include "firmware/print/store/job_facts.hpp"
#include "slicer/core/arena.hpp"
#include "slicer/rrep/rrep.hpp"
#include "slicer/supports/drawing/supports.hpp"

namespace plumbline {

/// What a print's masks are made of: an R-Rep and its supports, or an archive, of which the R-Rep has only the grid.
struct MaskParts {
  RRep rrep;
  Supports supports;
  std::span<const ArchiveLayer> archive;

  bool is_archive() const { return !archive.empty(); }
};

struct StoredJob {
  JobFacts facts;
  MaskParts parts;  ///< at the bottom of the arena
  std::uint64_t hash = 0;
};

/// Takes nothing from the heap.
/// @param hash  that of what was written
/// @returns false: errno has the reason
[[nodiscard]] bool write_job(const Descriptor& file, const JobFacts& facts, const MaskParts& parts,
                             std::uint64_t& hash);

/// @param path  for messages
/// @retval ErrorCode::kMalformed    the file is damaged or cut off
/// @retval ErrorCode::kUnsupported  another version of plumbline wrote it
/// @retval ErrorCode::kOutOfMemory, kCannotRead
[[nodiscard]] Expected<StoredJob> read_job(const Descriptor& file, const char* path, Arena& arena);

}  // namespace plumbline
