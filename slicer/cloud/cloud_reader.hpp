#pragma once
/// Reads a scan into a cloud at the top of the arena, and thins what exceeds the room it is given.

#include <cstdint>
#include <optional>

#include "slicer/cloud/cloud.hpp"
#include "slicer/core/byte_source.hpp"
#include "slicer/core/function_ref.hpp"
#include "slicer/core/progress.hpp"
#include "slicer/reader/scan_sources.hpp"

namespace plumbline::inline slicer {

struct CloudReadSettings {
  Mat3d rotation = Mat3d::Identity();  ///< from scan axes to print axes
  double first_cell = 0;     ///< of the thinning, scan units; 0: points are thinned only when the room is full
  double first_cell_mm = 0;  ///< the same where the first file is in mm by its format
};

/// What the headers of all files announce, known before the first point is read.
struct ScanAnnouncement {
  std::optional<std::uint64_t> points;  ///< at most; none where a file doesn't limit its number
  std::uint64_t reader_bytes = 0;       ///< ScanHeader::reader_bytes, the largest of the files
  std::uint64_t kept_bytes = 0;         ///< of the arena, for the heads of files that wait for their turn
  std::uint32_t most_views = kRuns;     ///< kMaxViews where a file states its own
  bool some_in_mm = false;              ///< by their format, whatever unit is asked for
  bool some_in_any_unit = false;        ///< for certain: a header that could not be read ahead says nothing
};

/// Decides how many points the cloud gets room for. Called once, when the headers of all files have been read.
/// @returns 1 or more, or the error that read_cloud() returns
using RoomForPoints = FunctionRef<Expected<std::uint32_t>(const ScanAnnouncement& announced)>;

/// The cloud stays at the top of the arena.
struct CloudReading {
  ScanSummaries scans;
  Cloud cloud;                   ///< its capacity is its size
  Vec3d offset = Vec3d::Zero();  ///< rotated scan coordinates of the cloud's origin
  std::uint64_t averaged = 0;    ///< scan points merged into another
  double cell = 0;               ///< of the thinning, scan units; 0: nothing was averaged
};

/// The most points that a file can hold by its header and its size. A header's count is an upper bound where the reader
/// stops at that count.
/// @returns none where neither limits them
std::optional<std::uint64_t> most_points(const ScanHeader& header, std::optional<std::uint64_t> file_bytes);

/// Reads a scan, which may be in several files: one after the other, in one frame.
/// @param sources   1 to kMostScans, each read once from start to end
/// @param room      asked before the first point; more points than it allows are thinned
/// @param progress  may be null
/// @retval all of read_scan() and of `room`; ErrorCode::kOutOfMemory
[[nodiscard]] Expected<CloudReading> read_cloud(ScanSources sources, const CloudReadSettings& settings,
                                                RoomForPoints room, Arena& arena, ProgressSink* progress);

}  // namespace plumbline::inline slicer
