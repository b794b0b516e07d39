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

namespace plumbline {

/// A scan at the top of the arena, in scan units, rotated.
struct PreparedScan {
  Cloud cloud;
  Vec3d offset = Vec3d::Zero();      ///< rotated scan coordinates of the cloud's origin
  Mat3d turned = Mat3d::Identity();  ///< after the rotation asked for: to the best way up, and to a level floor
  std::optional<float> floor;        ///< height of the floor that was cut off, coordinates of the cloud
  std::span<Vec3f> sample;           ///< points that the R-Rep is to be proven against, at the bottom of the arena
  bool has_surface = false;          ///< false: too few points have neighbours that face the same way

  /// Of the object, down to the floor that it stands on; rotated scan coordinates. The cloud is not empty.
  Box3d bounds() const;
  Box3d in_scan(const Box3f& local) const;  ///< from coordinates of the cloud to rotated scan coordinates
};

/// Called before the clustering, when normals and views are settled and no point has been left out.
/// @param tree  of scan.cloud
using Measurement = FunctionRef<Status(const PreparedScan& scan, const KdTree3& tree)>;
inline constexpr auto kNoMeasurement = [](const PreparedScan&, const KdTree3&) -> Status { return {}; };

/// Called when the scan has been read, before the stages that may take minutes.
using Admission = FunctionRef<Status(const PreparedScan& scan)>;
inline constexpr auto kAdmitAll = [](const PreparedScan&) -> Status { return {}; };

/// Reads a scan, completes its normals, aligns its views, and keeps the points of its surface, with classes and supports.
/// A scan without a surface is no error here.
/// @param settings  as returned by set_threads()
/// @param report    filled as far as it went, also on error
/// @retval ErrorCode::kOutOfMemory  before the scan is read where its header and the printer's grid show it; else by the stage
/// @retval ErrorCode::kCancelled and all of read_scan(), `measure` and `admit`
[[nodiscard]] Expected<PreparedScan> prepare(ScanSources sources, const SliceSettings& settings, Arena& arena,
                                             ProgressSink* progress, PreparationReport& report,
                                             Measurement measure = kNoMeasurement, Admission admit = kAdmitAll);

/// Called when the normals are settled, before the stages that may take minutes.
/// @param samples  of the scan's surface
using NormalsLook = FunctionRef<Status(const PreparedScan& scan, const SurfaceSamples& samples)>;

/// The first stages of prepare(): reads a scan and completes its normals. Of a scan of few points the surface is found too, which takes
/// no time and shows whether there is one.
/// @param report  filled as far as it went, also on error
/// @retval ErrorCode::kNoSurface  there is none, in the words of check_surface()
/// @retval all of prepare() and of `look`
[[nodiscard]] Status prepare_normals(ScanSources sources, const SliceSettings& settings, Arena& arena,
                                     ProgressSink* progress, PreparationReport& report, NormalsLook look);

/// @retval ErrorCode::kNoSurface  the scan has no surface: names the files and what to do
[[nodiscard]] Status check_has_surface(const PreparedScan& scan, ScanSources sources, const PreparationReport& found,
                                       const PlacementSettings& settings);

/// @retval ErrorCode::kNoSurface  the object is a speck or below the floor; else as check_has_surface()
[[nodiscard]] Status check_surface(const PreparedScan& scan, ScanSources sources, const PreparationReport& found,
                                   const PlacementSettings& settings);

/// Moves the cloud from scan units to print coordinates, mm, and sets the report's placement and lengths.
void move_to_print(const Placement& placement, PreparedScan& scan, const PreparationReport& found, SliceReport& report);

}  // namespace plumbline
