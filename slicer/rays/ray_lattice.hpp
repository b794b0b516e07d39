#pragma once
/// Decides the rays of a tile from a few of them, where the surface is smooth.

#include <array>
#include <cstdint>

#include "slicer/rays/ray_classifier.hpp"

namespace plumbline::inline slicer {

/// What is known of one ray of a tile.
struct TileRay {
  static constexpr std::uint32_t kMost = 12;  ///< crossings; a ray with more is not kept
  std::array<RayCrossing, kMost> crossing{};
  std::uint32_t count = 0;
  RayDecision decision = RayDecision::kOutside;
  bool known = false;
};

/// Decides a tile of rays with fewer searches than rays.
///
/// If the rays in the corners of a square cross the same sheets of the surface, and every point in the square lies on one of
/// these, then so do all rays in the square, and their crossings need only be looked for near predicted depths. In a whole tile
/// nine rays then give each sheet a polynomial of second degree along each axis. One more ray in each quarter of the tile
/// tests it; where the polynomials agree with it, they stand for the other rays. A tile that is no such square is cut into
/// smaller ones.
///
/// The corners of a square are its last ray and rays just before it, if these are known, so that squares share their corners. The
/// result depends on the tile and on those before it in its column of RayClassifier::kColumnSide rays a side.
class RayLattice {
 public:
  /// @param tolerance  mm: largest distance of the tested crossings from the polynomials
  explicit RayLattice(float tolerance) : tolerance_(tolerance) {}

  /// Decides rays of a tile that lies in the grid as a whole, after classifier.begin_tile(). The tiles of a column come row by row.
  /// @param column, row  pixel of the tile's first ray
  void decide(RayClassifier& classifier, std::uint32_t column, std::uint32_t row);

  /// Ray (c, r) of the tile. If it is not known it must be shot.
  const TileRay& ray(std::uint32_t c, std::uint32_t r) const { return rays_[(r + 1) * kRow + c + 1]; }
  std::uint32_t guided() const { return guided_; }              ///< rays of the tile, looked for near a prediction
  std::uint32_t interpolated() const { return interpolated_; }  ///< rays of the tile, by the polynomials

 private:
  static constexpr std::uint32_t kRow = kTileSide + 1;  ///< rays: one of the tile before, then those of the tile
  static constexpr std::int32_t kSide = kTileSide;

  /// A square of rays; c and r count columns and rows from the first ray of the tile.
  struct Square {
    std::int32_t c, r, side;
    std::int32_t last_c() const { return c + side - 1; }
    std::int32_t last_r() const { return r + side - 1; }
  };
  /// The rays that predict a square: those in columns c0 and c1 of rows r0 and r1.
  struct Corners {
    std::int32_t c0, r0, c1, r1;
  };
  /// Coefficients of 1, c, c^2, r, r c, r c^2, r^2, r^2 c, r^2 c^2 for the depth of a sheet, mm.
  using Sheet = std::array<float, 9>;
  /// Pixel of a tile's first ray.
  struct Place {
    std::uint32_t column = 1, row = 1;  ///< of no tile
    bool operator==(const Place&) const = default;
  };

  TileRay& at(std::int32_t c, std::int32_t r) {
    return rays_[static_cast<std::uint32_t>(r + 1) * kRow + static_cast<std::uint32_t>(c + 1)];
  }
  void begin(const Place& place);
  void end();
  void shoot(std::int32_t c, std::int32_t r);
  bool available(const Corners& corners);
  Corners corners_of(const Square& square);
  bool corners_agree(const Corners& corners);
  bool points_agree(const Square& square);
  bool predict(const Square& square);
  bool guide(std::int32_t c, std::int32_t r);
  void guide_all(const Square& square);
  void decide_tile();
  void decide_square(const Square& square);
  bool fit_polynomials();
  void interpolate(const Square& square);
  float depth(std::uint32_t sheet, float c, float r) const;
  float farthest_from_prediction(std::int32_t c, std::int32_t r);

  RayClassifier* classifier_ = nullptr;
  float tolerance_;
  Place place_;
  std::array<TileRay, std::size_t{kRow} * kRow> rays_;
  /// The last rows of the latest tiles, and which tiles these are.
  std::array<TileRay, RayClassifier::kColumnSide> above_;
  std::array<Place, RayClassifier::kColumnTiles> above_place_;
  TileRay like_;  ///< a ray that crosses the sheets
  std::array<Sheet, TileRay::kMost> sheets_{};
  std::uint32_t guided_ = 0;
  std::uint32_t interpolated_ = 0;
};

}  // namespace plumbline::inline slicer
