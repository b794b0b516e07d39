#include "slicer/placement/placement.hpp"

#include <algorithm>
#include <array>
#include <cmath>
#include <tuple>

#include "slicer/core/numbers/degrees.hpp"
#include "slicer/core/words/plural.hpp"

namespace plumbline::inline slicer {
namespace {

constexpr std::uint32_t kMargin = 3;  ///< pixels round an object in a grid of its own; opening and closing reach one

constexpr double kClear = 0.9998;     ///< of the largest scale: keeps the object inside despite rounding
constexpr double kWholeLayer = 1e-3;  ///< layers: a travel this much short of a whole layer is short by rounding only

/// The largest number of four digits not above `x`: a scale that we suggest still fits when typed as printed.
double rounded_down(double x) {
  if (!(x > 0)) return 0;
  double unit = 1;
  while (x < 1000 * unit) unit /= 10;
  while (x >= 10000 * unit) unit *= 10;
  return std::floor(x / unit) * unit;
}

/// @returns a length times a factor, in one rounding
float scaled(float mm, double factor) { return static_cast<float>(static_cast<double>(mm) * factor); }

std::uint32_t cells(double length, double pitch) {
  return static_cast<std::uint32_t>(std::clamp(std::ceil(length / pitch - 1e-6), 1.0, 4.0e9));
}

}  // namespace

const char* to_string(Units units) {
  switch (units) {
    case Units::kMillimetres: return "mm";
    case Units::kCentimetres: return "cm";
    case Units::kMetres: return "m";
    case Units::kInches: return "in";
    case Units::kAuto: return "auto";
  }
  return "unknown";
}

double millimetres_per(Units units) {
  switch (units) {
    case Units::kCentimetres: return 10;
    case Units::kMetres: return 1000;
    case Units::kInches: return 25.4;
    case Units::kMillimetres:
    case Units::kAuto: break;
  }
  return 1;
}

const char* to_string(Side side) {
  switch (side) {
    case Side::kWidth: return "width";
    case Side::kDepth: return "depth";
    case Side::kHeight: return "height";
    case Side::kLength: return "length";
  }
  return "unknown";
}

PlacementSettings PlacementSettings::with_units(Units other) const {
  PlacementSettings settings = *this;
  settings.units = other;
  return settings;
}

void PlacementSettings::correct(const Vec3d& by) {
  correction = by;
  layer_height_mm = scaled(layer_height_mm, 1 / by[2]);
  if (!printer) return;
  printer->pitch_x_mm = scaled(printer->pitch_x_mm, 1 / by[0]);
  printer->pitch_y_mm = scaled(printer->pitch_y_mm, 1 / by[1]);
  printer->travel_mm = scaled(printer->travel_mm, 1 / by[2]);
}

double PlacementSettings::finest_pitch_mm() const {
  return static_cast<double>(printer ? std::min(printer->pitch_x_mm, printer->pitch_y_mm) : pixel_pitch_mm);
}

double scale_of(const Vec3d& extent_mm, const PlacementSettings& settings) {
  if (!settings.size) return settings.scale;
  const Side side = settings.size->side;
  return settings.size->mm / (side == Side::kLength ? extent_mm.maxCoeff() : extent_mm[static_cast<int>(side)]);
}

Units guess_units(double longest_side) {
  for (const Units units : {Units::kMillimetres, Units::kMetres, Units::kCentimetres, Units::kInches}) {
    const double mm = longest_side * millimetres_per(units);
    // Most scanners write mm, so a small object in mm is likelier than a larger one in another unit.
    // Points fall a little short of the object's size: a ball of 20 mm may be 0.019998 units long.
    const double least = units == Units::kMillimetres ? 10 : 19;
    if (mm >= least && mm <= 500) return units;
  }
  return Units::kMillimetres;
}

Mat3d rotation_matrix(const Vec3d& degrees) {
  const SineCosine a = sine_cosine(degrees[0]);
  const SineCosine b = sine_cosine(degrees[1]);
  const SineCosine c = sine_cosine(degrees[2]);
  Mat3d x;
  Mat3d y;
  Mat3d z;
  x << 1, 0, 0, 0, a.cosine, -a.sine, 0, a.sine, a.cosine;
  y << b.cosine, 0, b.sine, 0, 1, 0, -b.sine, 0, b.cosine;
  z << c.cosine, -c.sine, 0, c.sine, c.cosine, 0, 0, 0, 1;
  return z * (y * x);
}

Mat4d Placement::transform() const {
  Mat4d m = Mat4d::Identity();
  m.topLeftCorner<3, 3>() = rotation * scale;
  m.topRightCorner<3, 1>() = shift;
  return m;
}

Vec3d Placement::origin_in_scan() const { return rotation.transpose() * (-shift / scale); }

double whole_layers(float travel_mm, float layer_height_mm) {
  const double layers = static_cast<double>(travel_mm) / static_cast<double>(layer_height_mm);
  return std::min(std::floor(layers + kWholeLayer), double{PrintGrid::kMaxLayers});
}

PrintGrid machine_grid(const PrintGrid& grid, const Vec3d& correction) {
  PrintGrid machine = grid;
  machine.pitch_x_mm = scaled(grid.pitch_x_mm, correction[0]);
  machine.pitch_y_mm = scaled(grid.pitch_y_mm, correction[1]);
  machine.layer_height_mm = scaled(grid.layer_height_mm, correction[2]);
  return machine;
}

PrintGrid panel_grid(const PrinterVolume& printer, float layer_height_mm) {
  const float layers = std::ceil(printer.travel_mm / layer_height_mm);
  return {.columns = printer.columns,
          .rows = printer.rows,
          .layers = static_cast<std::uint32_t>(std::clamp(layers, 1.0F, static_cast<float>(PrintGrid::kMaxLayers))),
          .pitch_x_mm = printer.pitch_x_mm,
          .pitch_y_mm = printer.pitch_y_mm,
          .layer_height_mm = layer_height_mm};
}

Expected<Placement> place(const Box3d& bounds, double unit_mm, const PlacementSettings& settings) {
  const Vec3d extent = bounds.size() * unit_mm;  // mm at scale 1
  Placement p;
  p.rotation = rotation_matrix(settings.rotation_degrees);
  p.grid.layer_height_mm = settings.layer_height_mm;
  double factor = scale_of(settings.sized_extent.value_or(bounds.size()) * unit_mm, settings);
  if (!settings.fit && std::isinf(factor)) {
    return fail(ErrorCode::kDoesNotFit,
                "the object is flat: no scale gives it a %s of %.4g mm.\tGive another side, or a scale",
                to_string(settings.size->side), settings.size->mm);
  }
  if (settings.printer) {
    const PrinterVolume& v = *settings.printer;
    p.grid = panel_grid(v, settings.layer_height_mm);
    const double lh = settings.layer_height_mm;
    // A margin of one pixel on each side keeps the outline on the panel after rounding.
    const Vec3d room(static_cast<double>(v.columns - 2) * static_cast<double>(v.pitch_x_mm),
                     static_cast<double>(v.rows - 2) * static_cast<double>(v.pitch_y_mm),
                     whole_layers(v.travel_mm, settings.layer_height_mm) * lh);
    const auto largest_in = [&extent](const Vec3d& space) {
      double largest = 1e30;
      for (int a = 0; a < 3; ++a) {
        if (extent[a] > 0) largest = std::min(largest, space[a] / extent[a]);
      }
      return largest;
    };
    // What is chosen or proposed here causes no finding at the panel's edge. On a panel too small for that room, the object has half of it.
    const PlacementRoom& kept = settings.room;
    const double beyond = 2 * (kEdgeMargin - 1);
    const Vec3d clear =
        room - Vec3d(beyond * static_cast<double>(v.pitch_x_mm), beyond * static_cast<double>(v.pitch_y_mm), 0);
    const auto half_at_least = [&room](const Vec3d& space) { return Vec3d(space.cwiseMax(room / 2)); };
    const double proposed = largest_in(half_at_least(clear));
    if (settings.fit) {
      factor = largest_in(half_at_least(clear - Vec3d(2 * kept.beside_mm, 2 * kept.beside_mm, kept.below_mm))) * kClear;
    } else if (factor > largest_in(room)) {
      static constexpr std::array kAxes = {std::tuple("wide (x)", ToldCode::kTooWide, Fact::kWidthMm),
                                           std::tuple("deep (y)", ToldCode::kTooDeep, Fact::kDepthMm),
                                           std::tuple("high (z)", ToldCode::kTooHigh, Fact::kHeightMm)};
      int worst = 0;
      for (int a = 1; a < 3; ++a) {
        if (extent[a] * room[worst] > extent[worst] * room[a]) worst = a;
      }
      const double least = settings.size ? settings.size->mm / factor : 1;
      const double most = rounded_down(proposed * kClear * least);
      const char* const option = settings.size ? to_string(settings.size->side) : "scale";
      const auto [axis, code, side] = kAxes[static_cast<std::size_t>(worst)];
      return telling(
          Told(code,
               {{side, extent[worst] * factor},
                {Fact::kLimitMm, room[worst]},
                {Fact::kExcessMm, extent[worst] * factor - room[worst]},
                {settings.size ? Fact::kMostMm : Fact::kMostScale, most}},
               settings.size ? option : ""),
          fail(ErrorCode::kDoesNotFit,
               "the object is %.2f mm %s, but the printer has room for %.2f mm: %.2f mm too much.\tUse a %s of %.4g%s "
               "or less, or rotate it",
               extent[worst] * factor, axis, room[worst], extent[worst] * factor - room[worst], option, most,
               settings.size ? " mm" : ""));
    }
    p.size_mm = extent * factor;
    p.grid.layers = cells(p.size_mm[2], lh);
    p.scale = unit_mm * factor;
    const Vec3d centre = bounds.centre() * p.scale;
    p.shift = {0.5 * v.columns * static_cast<double>(v.pitch_x_mm) - centre[0],
               0.5 * v.rows * static_cast<double>(v.pitch_y_mm) - centre[1], -bounds.low[2] * p.scale};
    return p;
  }
  const double pitch = settings.pixel_pitch_mm;
  p.size_mm = extent * factor;
  p.scale = unit_mm * factor;
  // The grid's planes are whole pitches from the scan's own zero. Otherwise the farthest outlier would decide where a flat
  // underside falls between two sampling heights.
  const Vec3d step(pitch, pitch, settings.layer_height_mm);
  const Vec3d low = (bounds.low * p.scale).cwiseQuotient(step).array().floor().matrix().cwiseProduct(step);
  const Vec3d reach = bounds.high * p.scale - low;
  p.grid.pitch_x_mm = p.grid.pitch_y_mm = settings.pixel_pitch_mm;
  // Rows of whole bytes, as printers' panels have: the PNG encoder can then use a mask unchanged.
  const std::uint32_t margin = kMargin + static_cast<std::uint32_t>(std::ceil(settings.room.beside_mm / pitch));
  p.grid.columns = (cells(reach[0], pitch) + 2 * margin + 7) / 8 * 8;
  p.grid.rows = cells(reach[1], pitch) + 2 * margin;
  p.grid.layers = cells(reach[2], settings.layer_height_mm);
  if (p.grid.columns > PrintGrid::kMaxSide || p.grid.rows > PrintGrid::kMaxSide ||
      p.grid.layers > PrintGrid::kMaxLayers) {
    const double most = std::min({(PrintGrid::kMaxSide - 2.0 * margin) * pitch / std::max(extent[0], extent[1]),
                                  PrintGrid::kMaxLayers * static_cast<double>(settings.layer_height_mm) / extent[2]});
    const double most_scale = rounded_down(most * kClear);
    return telling(
        Told(ToldCode::kTooManyPixels, {{Fact::kMostScale, most_scale}}),
        fail(ErrorCode::kDoesNotFit,
             "the object is %.5g x %.5g x %.5g mm, which is %u x %u pixels of %.4g mm and %u layer%s of %.4g mm; the "
             "limit is %u x %u pixels and %u layers.\tUse a scale of %.4g or less, larger pixels, or check the unit",
             p.size_mm[0], p.size_mm[1], p.size_mm[2], p.grid.columns, p.grid.rows, pitch, p.grid.layers,
             plural_s(p.grid.layers), static_cast<double>(settings.layer_height_mm), PrintGrid::kMaxSide,
             PrintGrid::kMaxSide, PrintGrid::kMaxLayers, most_scale));
  }
  p.shift = Vec3d(margin * pitch, margin * pitch, 0) - low;
  return p;
}

}  // namespace plumbline::inline slicer
