#pragma once
/// The print as a solid of cells: all that a page needs to draw it from any side.
///
///     0   "PLM1"
///     4   cells along x, y, z: 3 x uint16, then uint16: bit 0: there are supports, bit 1: it says what the surface rests on
///     12  low corner x, y, z: 3 x float32, mm on the panel and above the plate
///     24  size of a cell x, y, z: 3 x float32, mm
///     36  runs: the object's cells of layer 0 and the supports'; then for each layer z those of z + 1, but above the last, and what the
///         surface of z rests on
///
/// All little-endian. A layer's cells come row after row from the front, each a share of its volume, 0 to 63, in runs of one layer:
///
///     00vvvvvv            one cell of v, 1 to 62
///     01nnnnnn, 10nnnnnn  n + 1 cells of 0, of 63
///     110nnnnn m, 111nnnnn m  256 n + m + 1 cells of 0, of 63
///
/// Supports are in the stream only if there are any, and what it rests on only if that is known: for each cell of the layer that is on the
/// surface, in the same order, its Evidence e in runs of n + 1, eennnnnn. On the surface is a cell of more than 0, if it or a neighbour at one of its
/// faces is less than 63.

#include <array>
#include <cstddef>
#include <cstdint>
#include <span>

#include "slicer/core/arena.hpp"
#include "slicer/core/error.hpp"
#include "slicer/rrep/confidence.hpp"
#include "slicer/rrep/rrep.hpp"
#include "slicer/supports/drawing/supports.hpp"

namespace plumbline::firmware::inline pictures {

/// Pixels of the panel that a print takes; none: not known.
struct PartBox {
  std::uint32_t column = 0, row = 0, columns = 0, rows = 0;
};

/// Fixed in size, never on the heap.
struct PartModel {
  static constexpr std::size_t kMostBytes = 1'000'000;
  static constexpr std::uint32_t kMostCells = 256;  ///< along each side

  std::uint32_t size = 0;  ///< bytes; 0: there is none
  PartBox box;
  std::array<std::uint8_t, kMostBytes> memory{};

  bool there() const { return size > 0; }
  std::span<const std::uint8_t> bytes() const { return std::span(memory).first(size); }
  void clear() {
    size = 0;
    box = {};
  }
};

/// Bytes that make_part_model() takes at most.
std::size_t part_model_bytes(const PrintGrid& grid);

/// Reduces a print to cells of whole pixels and layers, as small as a model has room for.
/// @param map    what the surface rests on; empty: not known, as of a mesh
/// @param arena  part_model_bytes() at most are taken from its top and released
/// @param model  without an object, or after an error, there is none
/// @retval ErrorCode::kOutOfMemory
[[nodiscard]] Status make_part_model(const RRep& rrep, const Supports& supports, const ConfidenceMap& map, Arena& arena,
                                     PartModel& model);

}  // namespace plumbline::firmware::inline pictures
