#pragma once
/// What the slicer found and did, in numbers.

#include <cstdint>
#include <optional>

#include "slicer/core/numbers/length.hpp"
#include "slicer/core/stage_scope.hpp"
#include "slicer/layers/layer_features.hpp"
#include "slicer/mesh/mesh_counts.hpp"
#include "slicer/normals/normals.hpp"
#include "slicer/orientation/orientations.hpp"
#include "slicer/placement/placement.hpp"
#include "slicer/rays/ray_shooter.hpp"
#include "slicer/reader/scan_sources.hpp"
#include "slicer/rrep/components.hpp"
#include "slicer/rrep/confidence.hpp"
#include "slicer/rrep/mask_extent.hpp"
#include "slicer/rrep/point_proof.hpp"
#include "slicer/supports/support_settings.hpp"
#include "slicer/surface/clustering.hpp"
#include "slicer/surface/stray_pieces.hpp"
#include "slicer/views/registration.hpp"

namespace plumbline::inline slicer {

/// Lengths that were measured on the scan; see the stage results that they are copied from.
template <class Unit>
struct ScanLengths {
  Length<Unit> thinning_cell;   ///< side of a cell; 0: nothing was averaged
  Length<Unit> epsilon;         ///< ClusteringResult::epsilon
  Length<Unit> noise;           ///< ClusteringResult::noise
  Length<Unit> views_before;    ///< Registration::before
  Length<Unit> views_after;     ///< Registration::after
  Length<Unit> views_moved;     ///< Registration::moved
  Length<Unit> averaged_noise;  ///< of the scan's points, about, if neighbours were averaged; else 0
};
ScanLengths<Millimetre> in_mm(const ScanLengths<ScanUnit>& lengths, ScanScale scale);

/// A floor that was cut off the scan.
struct FloorCut {
  std::uint32_t points = 0;    ///< left out; 0: no floor
  double height = 0;           ///< z of the floor under the middle of the scan, rotated scan coordinates
  Vec3d size = Vec3d::Zero();  ///< of what was cut off, scan units
  float tilt = 0;              ///< sine of its angle to the horizontal, by which the scan was levelled
};

/// The views that the scan's files state.
struct StatedViews {
  std::uint32_t count = 0;     ///< with points; at most kMaxViews
  std::uint32_t scanners = 0;  ///< of these, those whose scanner can have stood where the file says
};

/// What was read.
struct ReadCounts {
  ScanSummary scan;                    ///< of all files: sum_of()
  ScanSummaries scans;                 ///< of each file
  std::optional<Units> ignored_units;  ///< asked for, but the format of the scan is in metres, whatever was asked for
  std::uint32_t cloud_capacity = 0;    ///< points the arena has room for
  std::uint32_t cloud_points = 0;      ///< points after thinning
  std::uint64_t averaged_points = 0;   ///< scan points that were averaged into another
};

/// Changes of the points before normals are made.
struct SettledCounts {
  std::uint32_t outliers = 0;       ///< left out
  std::uint32_t evened_points = 0;  ///< averaged into others along the lines that they lie in
};

/// The normals, and the way up that they show.
struct FoundNormals {
  NormalCounts normals;
  std::optional<Orientation> turned;   ///< the way that SliceSettings::orient has turned the scan
  std::optional<Orientation> upright;  ///< the scan plainly lies wrong, and this way up is better
};

/// Points of the scan that are on the object, and those that were left out before it was placed.
struct SurfaceCounts {
  ClusteringCounts clustering;
  FloorCut floor;
  std::uint32_t flying_points = 0;
  StrayPieces strays;
};

/// What was found before the object is placed.
struct PreparationReport : StageMemory, ReadCounts, SettledCounts, FoundNormals, SurfaceCounts {
  std::optional<MeshCounts> mesh;  ///< the files were sliced as a mesh; what is said of points is 0
  StatedViews stated_views;
  std::uint32_t averagings = 0;  ///< times that neighbours were averaged because no surface was found
};

struct SliceReport : PreparationReport {
  ScanLengths<Millimetre> lengths;    ///< 0 until the object is placed
  Units units = Units::kMillimetres;  ///< used
  bool units_guessed = false;
  Placement placement;
  bool flat_underside = false;  ///< it stands on the base plane
  float width_mm = 0;           ///< w of thesis III-2.c
  RayCounts rays;
  PointProof proof;
  ComponentCounts components;
  FeatureCounts features;
  std::optional<std::uint64_t>
      object_pixels;  ///< of all masks without supports, if they follow from what was counted anyway
  std::uint64_t crossings = 0;
  std::optional<PrintSize> asked_size;  ///< of the figure as it came
  bool turned_since = false;            ///< the figure has been turned, so that it need not be a side of the print
  Vec3d printed_mm =
      Vec3d::Zero();  ///< what the masks show of the object, without supports; the scan's noise may reach beyond it
  std::uint32_t sunk_layers = 0;  ///< cut off below, so that it stands flat
  SupportPlaces missed_supports;  ///< of settings.added: without a surface, so they get no tip
  MaskExtent extent;              ///< of the object
  ConfidenceMap confidence;       ///< in the arena below the R-Rep and valid as long as it is; empty unless asked for
};

}  // namespace plumbline::inline slicer
