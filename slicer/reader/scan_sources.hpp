#pragma once
/// The files of one job: parts of one scan in a common frame, read one after another.

#include <array>
#include <cstddef>
#include <cstdint>
#include <span>
#include <string_view>

#include "slicer/core/byte_source.hpp"
#include "slicer/reader/stream/scan_point.hpp"

namespace plumbline::inline slicer {

/// 1 to kMostScans streams, in the order in which they are read; after the scans any .conf that says where these lie (ViewPoses). Thinning depends on the order: the first point of a cell
/// fixes the cell's place in the cloud.
using ScanSources = std::span<ByteSource* const>;
inline constexpr std::size_t kMostScans = 32;  ///< files; each costs 4 KiB of arena for its header

/// Names the files in a message: "bust.ply", or "bust.ply and 2 more". Printable, whatever the files are called.
struct ScanTitle {
  std::array<char, 128> text = {};
  const char* c_str() const { return text.data(); }
};
ScanTitle title_of(ScanSources sources);
/// @param first  name of the first of `count` files
ScanTitle title_of(std::string_view first, std::size_t count);

/// What was read from each file, in order.
struct ScanSummaries {
  std::array<ScanSummary, kMostScans> each = {};
  std::size_t count = 0;

  void add(const ScanSummary& summary) { each[count++] = summary; }
  std::span<const ScanSummary> all() const { return std::span(each).first(count); }
};

/// The files as one: the header of the first, the sums of all. If only some files have normals, the points of the others
/// count as points without a normal. If one file is in mm by its format, all are.
ScanSummary sum_of(const ScanSummaries& summaries);

}  // namespace plumbline::inline slicer
