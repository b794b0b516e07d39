#pragma once
/// Where the object stands: units, scale, rotation, and its place on the printer or in a grid of its own.

#include <cstdint>
#include <optional>

#include "slicer/core/error.hpp"
#include "slicer/core/print_grid.hpp"
#include "slicer/core/vec.hpp"

namespace plumbline {

enum class Units : std::uint8_t { kMillimetres, kCentimetres, kMetres, kInches, kAuto };

/// "mm", "cm", "m", "in", "auto".
const char* to_string(Units units);
/// @param units  not kAuto
/// @returns mm a unit
double millimetres_per(Units units);

/// Guesses the unit from the longest side of a scan: the first of mm, m, cm, inches that makes it an object of 20 to
/// 500 mm; mm if none does.
Units guess_units(double longest_side);

/// What the printer offers. A grid of the object's own, without a printer, has neither limit.
struct PrinterVolume {
  std::uint32_t columns = 0;  ///< pixels of the panel
  std::uint32_t rows = 0;
  float pitch_x_mm = 0;
  float pitch_y_mm = 0;
  float travel_mm = 0;  ///< of the Z stage
};

struct PlacementSettings {
  Units units = Units::kMillimetres;
  double scale = 1;                        ///< times the size in the scan
  bool fit = false;                        ///< the largest scale that the printer takes, instead of `scale`
  Vec3d rotation_degrees = Vec3d::Zero();  ///< about x, then y, then z, right-handed
  float pixel_pitch_mm = 0.05F;            ///< of a grid of the object's own
  float layer_height_mm = 0.05F;
  std::optional<PrinterVolume> printer;
};

/// Rotation about x, then y, then z. Sine and cosine come from a polynomial of our own, exact at multiples of 90 degrees,
/// so that the same angles give the same masks on every machine.
Mat3d rotation_matrix(const Vec3d& degrees);

struct Placement {
  PrintGrid grid;
  Mat3d rotation = Mat3d::Identity();
  double scale = 1;               ///< mm a scan unit, all factors together
  Vec3d shift = Vec3d::Zero();    ///< print = scale * rotation * scan + shift, mm
  Vec3d size_mm = Vec3d::Zero();  ///< of the placed object

  Mat4d transform() const;  ///< scan to print, mm
  /// Scan coordinates of the outer corner of pixel (0, 0) on the underside of layer 0: the inverse transform of the origin.
  Vec3d origin_in_scan() const;
};

/// The grid of the printer's whole volume: what a job is planned for before its object is known.
PrintGrid panel_grid(const PrinterVolume& printer, float layer_height_mm);

/// @param bounds  of the rotated scan, scan units, finite
/// @param scale   mm a unit; settings.scale and units already in it. Ignored with settings.fit
/// @retval ErrorCode::kDoesNotFit  by how much, and the --scale that would fit
[[nodiscard]] Expected<Placement> place(const Box3d& bounds, double unit_mm, const PlacementSettings& settings);

}  // namespace plumbline
