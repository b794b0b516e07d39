#pragma once
/// A virtual structured-light scan of the analytic bust: what `plumbline sample` writes.

#include <cstdint>
#include <functional>
#include <string>

#include "slicer/core/error.hpp"
#include "slicer/reader/stream/scan_point.hpp"

namespace plumbline::firmware {

struct SampleSettings {
  std::uint64_t points = 300'000;  ///< exactly this many; kMinSamplePoints to kMaxSamplePoints
  std::uint64_t seed = 1;          ///< any; one seed and one count give the same bytes on every machine
};

inline constexpr std::uint64_t kMinSamplePoints = 1'000;
inline constexpr std::uint64_t kMaxSamplePoints = 50'000'000;

/// Scans the bust from the stations of a turntable and gives the points to `sink`, view by view.
///
/// Ten views at 20 degrees above the horizon, six at 60, and six from 20 degrees below it, without which no view
/// would see under shoulders and chin. The bust stands on a stand of its own size, so the underside stays open. A point is kept
/// if camera and projector both see it, less often the more the surface turns away. Noise of the depth, sigma
/// 0.02 mm at normal incidence; misregistration of every view, sigma 0.02 mm an axis; a few flying pixels at the edges
/// of the depth; one outlier in a thousand points. Normals are estimated from each view's noisy range image.
///
/// Coordinates are mm, z up, underside at z = 0, and floats: what a file would hold. The memory is one range image,
/// some 60 bytes for each point of a view.
///
/// @retval ErrorCode::kBadSetting  the number of points is out of its range
/// @retval ErrorCode::kCancelled   sink.progress() said so
/// @retval any error of the sink
[[nodiscard]] Status scan_bust(const SampleSettings& settings, PointSink& sink);

/// Scans the bust into a file: PLY, binary little-endian, float x y z nx ny nz, 24 bytes a point.
///
/// @param path      replaced if it exists; removed if the scan is not completed
/// @param progress  called with 0 to 1; returns false to stop the scan; may be empty
/// @retval ErrorCode::kCannotOpen   the file could not be created; with its name and the system's reason
/// @retval ErrorCode::kCannotWrite  the medium failed or is full; with the file's name and the system's reason
/// @retval ErrorCode::kBadSetting, kCancelled  as scan_bust()
[[nodiscard]] Status write_bust_scan(const std::string& path, const SampleSettings& settings,
                                     const std::function<bool(double)>& progress = {});

}  // namespace plumbline::firmware
