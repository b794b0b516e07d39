#pragma once
/// Places the object: units, scale, rotation, and position on the printer or in a grid of its own.

#include <cstdint>
#include <optional>

#include "slicer/core/error.hpp"
#include "slicer/core/numbers/vec.hpp"
#include "slicer/core/print_grid.hpp"

namespace plumbline::inline slicer {

enum class Units : std::uint8_t { kMillimetres, kCentimetres, kMetres, kInches, kAuto };

/// "mm", "cm", "m", "in", "auto".
const char* to_string(Units units);
/// Millimetres in a unit, which must not be kAuto.
double millimetres_per(Units units);

/// Guesses the unit from the longest side of a scan: mm if that makes it 10 to 500 mm long, the sizes that people print; else
/// the first of m, cm, inches that makes it 19 to 500 mm long. mm if none does. The one rule of slice(), inspect() and
/// the programs.
Units guess_units(double longest_side);

/// A side of the figure as it came, before any rotation, so that turning it never changes its size: along the scan's x, y or z, or the
/// longest of the three.
enum class Side : std::uint8_t { kWidth, kDepth, kHeight, kLength };
/// "width", "depth", "height", "length".
const char* to_string(Side side);

/// A size that the figure is to have, whatever the scan's unit is.
struct PrintSize {
  Side side = Side::kHeight;
  double mm = 0;
  bool operator==(const PrintSize&) const = default;
};
inline constexpr double kSmallestSizeMm = 1;
inline constexpr double kLargestSizeMm = 10'000;

/// The printer's panel and travel.
struct PrinterVolume {
  std::uint32_t columns = 0;  ///< pixels of the panel
  std::uint32_t rows = 0;
  float pitch_x_mm = 0;
  float pitch_y_mm = 0;
  float travel_mm = 0;  ///< of the Z stage
};

/// Room round the object that is kept for supports, mm.
struct PlacementRoom {
  double beside_mm = 0, below_mm = 0;
};

/// Pixels beside a fitted object that stay free, as the check for the panel's edge wants (CheckLimits::bound_margin).
inline constexpr std::uint32_t kEdgeMargin = 5;

struct PlacementSettings {
  Units units = Units::kMillimetres;
  double scale = 1;               ///< of the printed object to the scanned one
  bool fit = false;               ///< use the largest scale that fits the printer instead of `scale`
  std::optional<PrintSize> size;  ///< use the scale that gives this size instead of `scale`
  /// Scan units: sides of the figure as it came, before any rotation. `size` and a guessed unit are about these. None: it has not been turned.
  std::optional<Vec3d> sized_extent;
  Vec3d rotation_degrees = Vec3d::Zero();  ///< about x, then y, then z, right-handed
  float pixel_pitch_mm = 0.05F;            ///< without a printer
  float layer_height_mm = 0.05F;
  PlacementRoom room;                    ///< kept by `fit`, and in a grid of the object's own
  std::optional<PrinterVolume> printer;  ///< none: the grid is as large as the object
  /// By how much larger than the object its masks are, along x, y and z: it shrinks after it has cured. All lengths here, and those of the
  /// grid, are the object's: the machine's are this many times as large. Set by correct().
  Vec3d correction = Vec3d::Ones();

  PlacementSettings with_units(Units other) const;
  /// Makes lengths of the machine those of the object. Once, when all others are set.
  /// @param by  above 0
  void correct(const Vec3d& by);
  double finest_pitch_mm() const;  ///< of a pixel, along x or y
};

/// The scale of the print without `fit`: the one asked for, or the one that makes the size asked for.
/// @param extent_mm  of the figure as it came, at scale 1
/// @returns infinity if the object has no extent along that side
double scale_of(const Vec3d& extent_mm, const PlacementSettings& settings);

/// Rotation about x, then y, then z. It is exact at multiples of 90 degrees and does not use libm, so the same angles give
/// the same masks on every machine.
Mat3d rotation_matrix(const Vec3d& degrees);

struct Placement {
  PrintGrid grid;
  Mat3d rotation = Mat3d::Identity();
  double scale = 1;               ///< mm in a scan unit: unit and scale factor together
  Vec3d shift = Vec3d::Zero();    ///< print = scale * rotation * scan + shift, mm
  Vec3d size_mm = Vec3d::Zero();  ///< of the placed object

  Mat4d transform() const;  ///< scan to print, mm
  /// Scan coordinates of the grid's origin: the outer corner of pixel (0, 0) on the underside of layer 0.
  Vec3d origin_in_scan() const;
};

/// Whole layers that a travel has room for, PrintGrid::kMaxLayers at most.
double whole_layers(float travel_mm, float layer_height_mm);

/// The same grid with the pixels and layers of the machine.
/// @param correction  PlacementSettings::correction
PrintGrid machine_grid(const PrintGrid& grid, const Vec3d& correction);

/// The grid of the printer's whole volume. Memory is planned for it before the object's size is known.
PrintGrid panel_grid(const PrinterVolume& printer, float layer_height_mm);

/// Places the object in the middle of the panel, or in a grid of its own size, standing on the plate.
/// @param bounds   of the rotated scan, scan units, finite
/// @param unit_mm  mm in a scan unit; settings.units is not used
/// @retval ErrorCode::kDoesNotFit  the message says by how much, and which --scale or size fits
[[nodiscard]] Expected<Placement> place(const Box3d& bounds, double unit_mm, const PlacementSettings& settings);

}  // namespace plumbline::inline slicer
