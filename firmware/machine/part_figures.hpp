#pragma once
/// What a simulated printer knows of the part it made.

#include <cstdint>
#include <limits>
#include <optional>
#include <span>
#include <string>
#include <string_view>
#include <vector>

#include "slicer/core/numbers/oriented_point.hpp"

namespace plumbline::firmware {

/// Something that the masks asked for and the part has not.
struct LostPiece {
  std::string_view kind;  ///< "region dropped", ...: the objection's
  std::uint32_t layer = 0, last_layer = 0;
  double x_mm = 0, y_mm = 0;  ///< from the panel's corner
  double ml = 0;
};

/// How far the part's surface lies outwards of the true one, along the true normals, um; NaN where no point is of the kind.
struct DeviationFigures {
  std::string against = {};  ///< what is true: a mesh's name, or "r-rep"
  std::uint64_t points = 0;
  std::uint64_t missing = 0;  ///< without a surface in reach; the figures below leave them out
  std::uint64_t sealed = 0;   ///< of these, cured all along: gaps that have closed
  double rms = kNone;         ///< root of the mean square of all
  double down_mean = kNone;   ///< where the surface faces down, at most 60 degrees off
  double down_rms = kNone;    ///< the same, about its mean
  double wall_mean = kNone;   ///< steeper than 60 degrees
  double wall_rms = kNone;    ///< the same, about its mean
  double top_rms = kNone;     ///< faces up, at most 30 degrees off: about 0

  static constexpr double kNone = std::numeric_limits<double>::quiet_NaN();
};
/// @param deviations_mm  of the same points; not finite: no surface in reach, as Witness::deviations_mm()
DeviationFigures deviation_figures(std::string against, std::span<const OrientedPoint> truth,
                                   std::span<const float> deviations_mm);

struct PartFigures {
  double largest_peel_n = 0;  ///< of any layer
  double suction_cm2 = 0;     ///< largest area of sealed cavities that a layer was peeled with
  std::uint32_t traps = 0;    ///< closed cavities
  double trapped_ml = 0;      ///< resin in them
  double bleed_ml = 0;        ///< cured below down-facing surfaces by light beyond a layer
  std::vector<LostPiece> lost;
  std::optional<DeviationFigures> deviation = {};  ///< none: it was not measured

  double lost_ml() const {
    double sum = 0;
    for (const LostPiece& piece : lost) sum += piece.ml;
    return sum;
  }
};

}  // namespace plumbline::firmware
