#pragma once

#include <array>
#include <cstdint>
#include <span>
#include <string_view>

#include "firmware/pictures/mask_decoder.hpp"
#include "firmware/print/contract/contract.hpp"
#include "firmware/settings/board_file.hpp"
#include "hal/units.hpp"
#include "slicer/reader/scan_sources.hpp"

namespace plumbline {

/// A short text of fixed size, cut if it is longer, filled with 0 if it is shorter.
using ShortName = std::array<char, 64>;
ShortName short_name(std::string_view text);
/// The name of one file of a scan, the same way.
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
};

/// Hash of the values of a board file that masks and heights depend on. Layout and comments do not count.
std::uint64_t hash_of(const BoardFile& board);

}  // namespace plumbline
