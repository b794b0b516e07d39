#pragma once
/// From the bytes of a scan to the points of its surface: the stages that slice() and inspect() share.

#include <optional>
#include <span>

#include "slicer/cloud/cloud.hpp"
#include "slicer/cloud/kd_tree.hpp"
#include "slicer/core/arena.hpp"
#include "slicer/core/function_ref.hpp"
#include "slicer/orientation/surface_samples.hpp"
#include "slicer/reader/scan_sources.hpp"
#include "slicer/slice_report.hpp"
#include "slicer/slice_settings.hpp"

namespace plumbline::inline slicer {

/// A scan at the top of the arena, in scan units, rotated.
struct ReadScan {
  Cloud cloud;
  Vec3d offset = Vec3d::Zero();  ///< rotated scan coordinates of the cloud's origin
  ReadCounts counts;
  ScanLengths<ScanUnit> lengths;
  std::optional<float> floor;  ///< height of the floor that prepare() has cut off, coordinates of the cloud

  /// Of the object, down to the floor that it stands on; rotated scan coordinates. The cloud is not empty.
  Box3d bounds() const;
  Box3d in_scan(const Box3f& local) const;  ///< from coordinates of the cloud to rotated scan coordinates
};

/// The points of a scan's surface.
struct PreparedScan : ReadScan {
  Mat3d turned = Mat3d::Identity();  ///< after the rotation asked for: to the best way up, and to a level floor
  std::span<Vec3f> sample = {};      ///< points that the R-Rep is to be proven against, at the bottom of the arena
  bool has_surface = false;          ///< false: too few points have neighbours that face the same way
  /// Whether the points, before any are averaged, fill a volume; none: there was a surface at once.
  std::optional<bool> fills_volume = {};
  SurfaceCounts surface = {};
};

/// Reads a scan, and thins it where the arena has no room for all of its points.
/// @param settings  as returned by set_threads()
/// @param report    filled as far as it went, also on error
/// @retval ErrorCode::kOutOfMemory  before the scan is read where its header and the printer's grid show it
/// @retval ErrorCode::kCancelled and all of read_scan()
[[nodiscard]] Expected<ReadScan> read_points(ScanSources sources, const SliceSettings& settings,
                                             const StageContext& job, PreparationReport& report);

/// Sides of the figure as it came, scan units: before any rotation that was asked for or found, but levelled, and down to the floor that
/// was cut off.
/// @param settings  of prepare()
/// @param turned    PreparationReport::turned
/// @returns none: it has not been turned
std::optional<Vec3d> extent_as_it_came(const PreparedScan& scan, const SliceSettings& settings,
                                       const std::optional<Orientation>& turned);

/// Called before the clustering, when normals and views are settled and no point has been left out.
/// @param tree  of scan.cloud
using Measurement = FunctionRef<Status(const PreparedScan& scan, const KdTree3& tree)>;
inline constexpr auto kNoMeasurement = [](const PreparedScan&, const KdTree3&) -> Status { return {}; };

/// Completes the normals of a scan, aligns its views, and keeps the points of its surface, with classes and supports.
/// A scan without a surface is no error here.
/// @param scan    its points are at more than one place; its cloud is consumed
/// @param report  filled as far as it went, also on error
/// @retval ErrorCode::kOutOfMemory, kCancelled and all of `measure`
[[nodiscard]] Expected<PreparedScan> prepare(const ReadScan& scan, const SliceSettings& settings,
                                             const StageContext& job, PreparationReport& report,
                                             Measurement measure = kNoMeasurement);

/// Called when the normals are settled, before the stages that may take minutes.
/// @param samples  of the scan's surface
using NormalsLook = FunctionRef<Status(const PreparedScan& scan, const SurfaceSamples& samples)>;

/// The first stages of prepare(): reads a scan or a mesh and completes its normals. Of a scan of few points the surface is found too,
/// which takes no time and shows whether there is one.
/// @param report  filled as far as it went, also on error
/// @retval ErrorCode::kNoSurface  there is none, in the words of check_surface()
/// @retval all of prepare() and of `look`
[[nodiscard]] Status prepare_normals(ScanSources sources, const SliceSettings& settings, Arena& arena,
                                     ProgressSink* progress, PreparationReport& report, NormalsLook look);

/// @retval ErrorCode::kNoSurface  the scan has no surface: names the files and what to do
[[nodiscard]] Status check_has_surface(const PreparedScan& scan, ScanSources sources,
                                       const PlacementSettings& settings);

/// @retval ErrorCode::kNoSurface  the object is a speck or below the floor; else as check_has_surface()
[[nodiscard]] Status check_surface(const PreparedScan& scan, ScanSources sources, const PlacementSettings& settings);

/// A scan where it is printed: print coordinates, mm.
struct PlacedScan {
  Cloud cloud;          ///< at the top of the arena
  Placement placement;  ///< from the scan as it was read
  ScanLengths<Millimetre> lengths;
  std::optional<float> floor = {};  ///< height of the floor that was cut off
  std::span<const Vec3f> sample;    ///< PreparedScan::sample
  ClassCounts classes;              ///< of the surface's points
  std::uint32_t read_points = 0;    ///< of the cloud after reading, for which its room was taken
};
/// Moves the points of a scan from scan units to print coordinates.
/// @param placement   of the rotated scan
/// @param outline_mm  by which outlines are moved: see outline_move()
PlacedScan move_to_print(const Placement& placement, const PreparedScan& scan, double outline_mm = 0);

}  // namespace plumbline::inline slicer
