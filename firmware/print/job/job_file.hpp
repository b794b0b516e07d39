#pragma once
/// The stored job: a header, JobFacts, R-Rep and supports or the layers of an archive, and a hash of all of it.

#include <sys/types.h>

#include <array>
#include <cstdint>
#include <span>
#include <string_view>

#include "firmware/archive/layer_archive.hpp"
#include "firmware/io/descriptor.hpp"
#include "firmware/pictures/mask_decoder.hpp"
#include "firmware/print/job/contract.hpp"
#include "firmware/settings/board_file.hpp"
#include "hal/units.hpp"
#include "slicer/core/arena.hpp"
#include "slicer/reader/scan_sources.hpp"
#include "slicer/rrep/rrep.hpp"
#include "slicer/supports/drawing/supports.hpp"

namespace plumbline::firmware {

/// Everybody may read what is stored; only the daemon may write it.
constexpr mode_t kFileMode = 0644;
constexpr mode_t kFolderMode = 0755;

/// A name in a field of fixed size: longer ones are cut, shorter ones padded with zeros.
using ShortName = std::array<char, 64>;
ShortName short_name(std::string_view text);
/// Likewise the name of one file of a scan.
using FileName = std::array<char, 80>;
FileName file_name(std::string_view text);

std::string_view view(std::span<const char> name);

/// Everything about a print except what its masks are made of. Stored byte for byte, so it holds no pointers.
struct JobFacts {
  ShortName scan = {};  ///< for people: its file, or the first one and how many more
  ShortName printer = {};
  ShortName profile = {};
  std::uint64_t print_id = 0;      ///< random, so that no two prints of a scan are taken for each other
  std::uint64_t scan_hash = 0;     ///< of the file's bytes
  std::uint64_t printer_hash = 0;  ///< hash_of() the board file
  std::uint64_t cured_pixels = 0;  ///< of all masks together
  MaskTurn turn;                   ///< of an archive's layers
  Contract contract;
  std::uint32_t file_count = 0;                 ///< of the scan; at most kMostScans
  std::array<FileName, kMostScans> files = {};  ///< their names; longer ones are cut

  /// @pre called at most kMostScans times
  void add_file(std::string_view name);
  std::span<const FileName> scan_files() const { return std::span(files).first(file_count); }
};

/// Hash of the values of a board file that masks and heights depend on. Layout and comments do not count.
std::uint64_t hash_of(const BoardFile& board);

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

}  // namespace plumbline::firmware
