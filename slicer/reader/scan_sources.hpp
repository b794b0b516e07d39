#pragma once
/// The files of one job: parts of one scan in one frame, read one after the other.

#include <array>
#include <cstddef>
#include <cstdint>
#include <span>

#include "slicer/core/byte_source.hpp"
#include "slicer/reader/stream/scan_point.hpp"

namespace plumbline {

/// 1 to kMostScans streams, in the order in which they are read. The order counts: where points are thinned, the first of a
/// cell gives it its place.
using ScanSources = std::span<ByteSource* const>;
inline constexpr std::size_t kMostScans = 32;

/// What a message calls them: "bust.ply", or "bust.ply and 2 more".
struct ScanTitle {
  std::array<char, 128> text = {};
  const char* c_str() const { return text.data(); }
};
ScanTitle title_of(ScanSources sources);

/// What was read of each file, in their order.
struct ScanSummaries {
  std::array<ScanSummary, kMostScans> each = {};
  std::size_t count = 0;

  void add(const ScanSummary& summary) { each[count++] = summary; }
  std::span<const ScanSummary> all() const { return std::span(each).first(count); }
};

/// All files as if they were one: the head of the first, the sums of all. Where some have normals and others none, the
/// points of those count as points without one.
ScanSummary sum_of(const ScanSummaries& summaries);

}  // namespace plumbline
