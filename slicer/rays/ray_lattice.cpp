#include "slicer/rays/ray_lattice.hpp"

#include <algorithm>
#include <cmath>

namespace plumbline::inline slicer {
namespace {

/// A point up to this many support radii above or below a sheet lies on it. Twice the spread of points on noisy scans.
constexpr float kOnSheet = 0.6F;
/// A point whose normal has a smaller z component lies on a sheet of either direction; so does a steep sheet's noise.
constexpr float kSteep = 0.3F;

/// Rays along each axis that determine the polynomials, and those that test them.
constexpr std::array<std::int32_t, 3> kNodes = {0, 4, kTileSide - 1};
constexpr std::array<std::int32_t, 2> kTests = {2, 5};

/// Rays a side of the smallest squares. In a smaller one every ray would be a corner.
constexpr std::int32_t kSmallestSquare = 2;

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

/// Takes over what is known of the rays just before the tile.
void RayLattice::begin(const Place& place) {
  const bool has_left =
      place.column % RayClassifier::kColumnSide != 0 && place_ == Place{place.column - kTileSide, place.row};
  for (std::int32_t r = -1; r < kSide; ++r) at(-1, r) = has_left ? at(kSide - 1, r) : TileRay{};
  const std::uint32_t number = place.column / kTileSide % RayClassifier::kColumnTiles;
  const bool has_above =
      place.row % RayClassifier::kColumnSide != 0 && above_place_[number] == Place{place.column, place.row - kTileSide};
  for (std::int32_t c = 0; c < kSide; ++c) {
    at(c, -1) = has_above ? above_[number * kTileSide + static_cast<std::uint32_t>(c)] : TileRay{};
    for (std::int32_t r = 0; r < kSide; ++r) at(c, r).known = false;
  }
  place_ = place;
  guided_ = interpolated_ = 0;
}

/// Keeps the last row for the tile below.
void RayLattice::end() {
  const std::uint32_t number = place_.column / kTileSide % RayClassifier::kColumnTiles;
  above_place_[number] = place_;
  for (std::int32_t c = 0; c < kSide; ++c)
    above_[number * kTileSide + static_cast<std::uint32_t>(c)] = at(c, kSide - 1);
}

/// Shoots a ray of the tile, unless it is known.
void RayLattice::shoot(std::int32_t c, std::int32_t r) {
  TileRay& to = at(c, r);
  if (to.known) return;
  const ClassifiedRay ray =
      classifier_->ray(place_.column + static_cast<std::uint32_t>(c), place_.row + static_cast<std::uint32_t>(r));
  if (ray.crossings.size() > TileRay::kMost) return;
  std::ranges::copy(ray.crossings, to.crossing.begin());
  to.count = static_cast<std::uint32_t>(ray.crossings.size());
  to.decision = ray.decision;
  to.known = true;
}

/// Whether the corners that are not rays of the tile are known.
bool RayLattice::available(const Corners& corners) {
  for (const std::int32_t r : {corners.r0, corners.r1}) {
    for (const std::int32_t c : {corners.c0, corners.c1}) {
      if ((c < 0 || r < 0) && !at(c, r).known) return false;
    }
  }
  return true;
}

/// Rays just before the square, where they are available. Of the square only the last ray needs to be shot then.
RayLattice::Corners RayLattice::corners_of(const Square& square) {
  for (const std::int32_t r : {square.r - 1, square.r}) {
    for (const std::int32_t c : {square.c - 1, square.c}) {
      const Corners corners{c, r, square.last_c(), square.last_r()};
      if (available(corners)) return corners;
    }
  }
  return {square.c, square.r, square.last_c(), square.last_r()};
}

/// Whether the rays in the corners cross the same sheets, all of them measured or the base plane.
bool RayLattice::corners_agree(const Corners& corners) {
  for (const std::int32_t r : {corners.r0, corners.r1}) {
    for (const std::int32_t c : {corners.c0, corners.c1}) {
      if (r >= 0 && c >= 0) shoot(c, r);
      const TileRay& ray = at(c, r);
      if (c == corners.c0 && r == corners.r0) like_ = ray;
      if (!ray.known || ray.count != like_.count) return false;
      for (std::uint32_t i = 0; i < like_.count; ++i) {
        const RayCrossing& crossing = ray.crossing[i];
        if (crossing.evidence != like_.crossing[i].evidence || crossing.extrapolated) return false;
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
  const auto first_c = static_cast<float>(place_.column);
  const auto first_r = static_cast<float>(place_.row);
  const float low_x = (first_c + static_cast<float>(square.c)) * grid.pitch_x_mm;
  const float low_y = (first_r + static_cast<float>(square.r)) * grid.pitch_y_mm;
  const float high_x = low_x + static_cast<float>(square.side) * grid.pitch_x_mm;
  const float high_y = low_y + static_cast<float>(square.side) * grid.pitch_y_mm;
  for (std::uint32_t t = 0; t < gatherer.tile_points(); ++t) {
    const RayGatherer::TilePoint p = gatherer.tile_point(t);
    const float x = p.position[0];
    const float y = p.position[1];
    if (x < low_x || x > high_x || y < low_y || y > high_y) continue;
    const float c = x / grid.pitch_x_mm - grid.ray_x - first_c;
    const float r = y / grid.pitch_y_mm - grid.ray_y - first_r;
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
  const Corners corners = corners_of(square);
  if (!corners_agree(corners)) return false;
  const float inverse_c = 1.0F / static_cast<float>(corners.c1 - corners.c0);
  const float inverse_r = 1.0F / static_cast<float>(corners.r1 - corners.r0);
  const auto c0 = static_cast<float>(corners.c0);
  const auto r0 = static_cast<float>(corners.r0);
  for (std::uint32_t i = 0; i < like_.count; ++i) {
    const float z00 = like_.crossing[i].depth;
    const float z10 = at(corners.c1, corners.r0).crossing[i].depth;
    const float z01 = at(corners.c0, corners.r1).crossing[i].depth;
    const float z11 = at(corners.c1, corners.r1).crossing[i].depth;
    const float along_c = (z10 - z00) * inverse_c;
    const float along_r = (z01 - z00) * inverse_r;
    const float twist = (z11 - z10 - z01 + z00) * inverse_c * inverse_r;
    sheets_[i] = {z00 - along_c * c0 - along_r * r0 + twist * c0 * r0, along_c - twist * r0, 0, along_r - twist * c0,
                  twist};
  }
  return points_agree(square);
}

/// Finds the sheets on a ray near their predicted depths, unless the ray is known.
/// @returns false if one is not there
bool RayLattice::guide(std::int32_t c, std::int32_t r) {
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
    const auto found = classifier_->sheet_near(place_.column + static_cast<std::uint32_t>(c),
                                               place_.row + static_cast<std::uint32_t>(r), predicted, i % 2 == 0);
    if (!found || (i > 0 && *found <= below)) return false;
    crossing.depth = *found;
  }
  ++guided_;
  ray.known = true;
  return true;
}

void RayLattice::guide_all(const Square& square) {
  for (std::int32_t r = square.r; r <= square.last_r(); ++r) {
    for (std::int32_t c = square.c; c <= square.last_c(); ++c) guide(c, r);
  }
}

/// @returns false if a ray that determines the polynomials could not be guided
bool RayLattice::fit_polynomials() {
  for (const std::int32_t r : kNodes) {
    for (const std::int32_t c : kNodes) {
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

float RayLattice::farthest_from_prediction(std::int32_t c, std::int32_t r) {
  float farthest = 0;
  for (std::uint32_t i = 0; i < like_.count; ++i) {
    if (like_.crossing[i].evidence == Evidence::kBase) continue;
    const float predicted = depth(i, static_cast<float>(c), static_cast<float>(r));
    farthest = std::max(farthest, std::abs(at(c, r).crossing[i].depth - predicted));
  }
  return farthest;
}

void RayLattice::interpolate(const Square& square) {
  for (std::int32_t r = square.r; r <= square.last_r(); ++r) {
    for (std::int32_t c = square.c; c <= square.last_c(); ++c) {
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

void RayLattice::decide(RayClassifier& classifier, std::uint32_t column, std::uint32_t row) {
  classifier_ = &classifier;
  begin({column, row});
  decide_tile();
  end();
}

void RayLattice::decide_tile() {
  const Square tile{0, 0, kSide};
  const bool whole = predict(tile) && fit_polynomials();
  for (std::int32_t quarter = 0; quarter < 4; ++quarter) {
    const std::int32_t half = kSide / 2;
    const Square square{quarter % 2 * half, quarter / 2 * half, half};
    if (!whole) {
      decide_square(square);
      continue;
    }
    const std::int32_t c = kTests[static_cast<std::size_t>(quarter % 2)];
    const std::int32_t r = kTests[static_cast<std::size_t>(quarter / 2)];
    if (!guide(c, r)) continue;
    if (farthest_from_prediction(c, r) <= tolerance_) {
      interpolate(square);
    } else {
      guide_all(square);
    }
  }
}

void RayLattice::decide_square(const Square& square) {
  if (predict(square)) {
    guide_all(square);
    return;
  }
  const std::int32_t half = square.side / 2;
  if (half < kSmallestSquare) return;
  for (const std::int32_t r : {square.r, square.r + half}) {
    for (const std::int32_t c : {square.c, square.c + half}) decide_square({c, r, half});
  }
}

}  // namespace plumbline::inline slicer
