#include "slicer/rays/ray_lattice.hpp"

#include <algorithm>
#include <cmath>

namespace plumbline {
namespace {

/// A point up to this many support radii above or below a sheet lies on it. Twice the spread of points on noisy scans.
constexpr float kOnSheet = 0.6F;
/// A point whose normal has a smaller z component lies on a sheet of either direction; so does a steep sheet's noise.
constexpr float kSteep = 0.3F;

/// Rays along each axis that determine the polynomials, and those that test them.
constexpr std::array<std::uint32_t, 3> kNodes = {0, 4, kTileSide - 1};
constexpr std::array<std::uint32_t, 2> kTests = {2, 5};

using Row = std::array<float, 3>;

/// Coefficients of 1, t, t^2 of the polynomial with these values at kNodes.
Row through_nodes(const Row& value) {
  constexpr auto kMiddle = static_cast<float>(kNodes[1]);
  constexpr auto kEnd = static_cast<float>(kNodes[2]);
  const float first = (value[1] - value[0]) / kMiddle;
  const float second = ((value[2] - value[1]) / (kEnd - kMiddle) - first) / kEnd;
  return {value[0], first - second * kMiddle, second};
}

}  // namespace

void RayLattice::shoot_corners(const Square& square) {
  for (const std::uint32_t r : {square.r, square.last_r()}) {
    for (const std::uint32_t c : {square.c, square.last_c()}) {
      TileRay& to = at(c, r);
      if (to.known) continue;
      const ClassifiedRay ray = classifier_->ray(column_ + c, row_ + r);
      if (ray.crossings.size() > TileRay::kMost) continue;
      std::ranges::copy(ray.crossings, to.crossing.begin());
      to.count = static_cast<std::uint32_t>(ray.crossings.size());
      to.decision = ray.decision;
      to.known = true;
    }
  }
}

/// Whether the rays in the corners cross the same sheets, all of them measured or the base plane.
bool RayLattice::corners_agree(const Square& square) {
  const TileRay& first = at(square.c, square.r);
  for (const std::uint32_t r : {square.r, square.last_r()}) {
    for (const std::uint32_t c : {square.c, square.last_c()}) {
      const TileRay& ray = at(c, r);
      if (!ray.known || ray.count != first.count || ray.decision != first.decision) return false;
      for (std::uint32_t i = 0; i < first.count; ++i) {
        const RayCrossing& crossing = ray.crossing[i];
        if (crossing.evidence != first.crossing[i].evidence || crossing.extrapolated) return false;
        if (crossing.evidence == Evidence::kWinding) return false;
      }
    }
  }
  return true;
}

/// Whether every point in a square lies on one of the predicted sheets.
bool RayLattice::points_agree(const Square& square) {
  const PrintGrid& grid = classifier_->grid();
  const RayGatherer& gatherer = classifier_->gatherer();
  const float low_c = static_cast<float>(square.c) - 0.5F;
  const float low_r = static_cast<float>(square.r) - 0.5F;
  const auto side = static_cast<float>(square.side);
  for (std::uint32_t t = 0; t < gatherer.tile_points(); ++t) {
    const RayGatherer::TilePoint p = gatherer.tile_point(t);
    const float c = p.position[0] / grid.pitch_x_mm - 0.5F - static_cast<float>(column_);
    const float r = p.position[1] / grid.pitch_y_mm - 0.5F - static_cast<float>(row_);
    if (c < low_c || c > low_c + side || r < low_r || r > low_r + side) continue;
    const float slope = p.slope;
    const float limit = kOnSheet * p.radius / std::max(std::abs(slope), kSteep);
    bool on_sheet = false;
    for (std::uint32_t i = 0; i < like_.count && !on_sheet; ++i) {
      const bool exiting = i % 2 == 1;
      if (std::abs(slope) > kSteep && (slope > 0) != exiting) continue;
      on_sheet = std::abs(p.position[2] - depth(i, c, r)) <= limit;
    }
    if (!on_sheet) return false;
  }
  return true;
}

/// Predicts the sheets in a square from its corners.
/// @returns false if the square may hold anything else
bool RayLattice::predict(const Square& square) {
  if (!corners_agree(square)) return false;
  like_ = at(square.c, square.r);
  const float inverse = 1.0F / static_cast<float>(square.side - 1);
  const auto c0 = static_cast<float>(square.c);
  const auto r0 = static_cast<float>(square.r);
  for (std::uint32_t i = 0; i < like_.count; ++i) {
    const float z00 = like_.crossing[i].depth;
    const float z10 = at(square.last_c(), square.r).crossing[i].depth;
    const float z01 = at(square.c, square.last_r()).crossing[i].depth;
    const float z11 = at(square.last_c(), square.last_r()).crossing[i].depth;
    const float along_c = (z10 - z00) * inverse;
    const float along_r = (z01 - z00) * inverse;
    const float twist = (z11 - z10 - z01 + z00) * inverse * inverse;
    sheets_[i] = {z00 - along_c * c0 - along_r * r0 + twist * c0 * r0, along_c - twist * r0, 0, along_r - twist * c0,
                  twist};
  }
  return points_agree(square);
}

/// Finds the sheets on a ray near their predicted depths, unless the ray is known.
/// @returns false if one is not there
bool RayLattice::guide(std::uint32_t c, std::uint32_t r) {
  TileRay& ray = at(c, r);
  if (ray.known) return true;
  ray.count = like_.count;
  ray.decision = like_.decision;
  for (std::uint32_t i = 0; i < ray.count; ++i) {
    RayCrossing& crossing = ray.crossing[i] = like_.crossing[i];
    const float below = i > 0 ? ray.crossing[i - 1].depth : 0;
    if (crossing.evidence == Evidence::kBase) {
      if (crossing.depth < below) return false;
      continue;
    }
    const float predicted = depth(i, static_cast<float>(c), static_cast<float>(r));
    const auto found = classifier_->sheet_near(column_ + c, row_ + r, predicted, i % 2 == 0);
    if (!found || (i > 0 && *found <= below)) return false;
    crossing.depth = *found;
  }
  ++guided_;
  ray.known = true;
  return true;
}

void RayLattice::guide_all(const Square& square) {
  for (std::uint32_t r = square.r; r <= square.last_r(); ++r) {
    for (std::uint32_t c = square.c; c <= square.last_c(); ++c) guide(c, r);
  }
}

/// @returns false if a ray that determines the polynomials could not be guided
bool RayLattice::fit_polynomials() {
  for (const std::uint32_t r : kNodes) {
    for (const std::uint32_t c : kNodes) {
      if (!guide(c, r)) return false;
    }
  }
  for (std::uint32_t i = 0; i < like_.count; ++i) {
    std::array<Row, 3> rows;
    for (std::size_t r = 0; r < 3; ++r) {
      Row depths;
      for (std::size_t c = 0; c < 3; ++c) depths[c] = at(kNodes[c], kNodes[r]).crossing[i].depth;
      rows[r] = through_nodes(depths);
    }
    for (std::size_t power = 0; power < 3; ++power) {
      const Row along_r = through_nodes({rows[0][power], rows[1][power], rows[2][power]});
      for (std::size_t r = 0; r < 3; ++r) sheets_[i][3 * r + power] = along_r[r];
    }
  }
  return true;
}

float RayLattice::depth(std::uint32_t sheet, float c, float r) const {
  const Sheet& k = sheets_[sheet];
  return (k[0] + c * (k[1] + c * k[2])) + r * ((k[3] + c * (k[4] + c * k[5])) + r * (k[6] + c * (k[7] + c * k[8])));
}

float RayLattice::farthest_from_prediction(std::uint32_t c, std::uint32_t r) {
  float farthest = 0;
  for (std::uint32_t i = 0; i < like_.count; ++i) {
    if (like_.crossing[i].evidence == Evidence::kBase) continue;
    const float predicted = depth(i, static_cast<float>(c), static_cast<float>(r));
    farthest = std::max(farthest, std::abs(at(c, r).crossing[i].depth - predicted));
  }
  return farthest;
}

void RayLattice::interpolate(const Square& square) {
  for (std::uint32_t r = square.r; r <= square.last_r(); ++r) {
    for (std::uint32_t c = square.c; c <= square.last_c(); ++c) {
      TileRay& ray = at(c, r);
      if (ray.known) continue;
      ray = like_;
      for (std::uint32_t i = 0; i < ray.count; ++i) {
        RayCrossing& crossing = ray.crossing[i];
        if (crossing.evidence != Evidence::kBase) {
          crossing.depth = depth(i, static_cast<float>(c), static_cast<float>(r));
        }
        // Sheets that touch can change places.
        if (i > 0 && crossing.depth < ray.crossing[i - 1].depth) ray.known = false;
      }
      interpolated_ += ray.known ? 1 : 0;
    }
  }
}

std::span<const TileRay> RayLattice::decide(std::uint32_t column, std::uint32_t row) {
  column_ = column;
  row_ = row;
  guided_ = interpolated_ = 0;
  for (TileRay& ray : rays_) ray.known = false;
  const Square tile{0, 0, kSide};
  shoot_corners(tile);
  const bool whole = predict(tile) && fit_polynomials();
  for (std::size_t quarter = 0; quarter < 4; ++quarter) {
    constexpr std::uint32_t kHalf = kSide / 2;
    const Square square{quarter % 2 == 0 ? 0 : kHalf, quarter < 2 ? 0 : kHalf, kHalf};
    if (!whole) {
      shoot_corners(square);
      if (predict(square)) guide_all(square);
      continue;
    }
    const std::uint32_t c = kTests[quarter % 2];
    const std::uint32_t r = kTests[quarter / 2];
    if (!guide(c, r)) continue;
    if (farthest_from_prediction(c, r) <= tolerance_) {
      interpolate(square);
    } else {
      guide_all(square);
    }
  }
  return rays_;
}

}  // namespace plumbline
