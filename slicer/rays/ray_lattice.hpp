#pragma once
/// Decides the rays of a tile from a few of them, where the surface is smooth.

#include <array>
#include <cstdint>
#include <span>

#include "slicer/rays/ray_classifier.hpp"

namespace plumbline {

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
/// tests it; where the polynomials agree with it, they stand for the other rays.
///
/// The result depends on the tile alone.
class RayLattice {
 public:
  /// @param tolerance  mm: largest distance of the tested crossings from the polynomials
  RayLattice(RayClassifier& classifier, float tolerance) : classifier_(&classifier), tolerance_(tolerance) {}

  /// Decides rays of a tile of which all rays are interested, after classifier.begin_tile().
  /// @param column, row  pixel of the tile's first ray
  /// @returns its rays, row by row. Those that are not known must be shot. Valid until the next call
  std::span<const TileRay> decide(std::uint32_t column, std::uint32_t row);

  std::uint32_t guided() const { return guided_; }              ///< rays of the tile, looked for near a prediction
  std::uint32_t interpolated() const { return interpolated_; }  ///< rays of the tile, by the polynomials

 private:
  static constexpr std::uint32_t kSide = kTileSide;
  static constexpr std::uint32_t kLast = kSide - 1;

  /// A square of rays; c and r count columns and rows from the first ray of the tile.
  struct Square {
    std::uint32_t c, r, side;
    std::uint32_t last_c() const { return c + side - 1; }
    std::uint32_t last_r() const { return r + side - 1; }
  };
  /// Coefficients of 1, c, c^2, r, r c, r c^2, r^2, r^2 c, r^2 c^2 for the depth of a sheet, mm.
  using Sheet = std::array<float, 9>;

  TileRay& at(std::uint32_t c, std::uint32_t r) { return rays_[r * kSide + c]; }
  void shoot_corners(const Square& square);
  bool corners_agree(const Square& square);
  bool points_agree(const Square& square);
  bool predict(const Square& square);
  bool guide(std::uint32_t c, std::uint32_t r);
  void guide_all(const Square& square);
  bool fit_polynomials();
  void interpolate(const Square& square);
  float depth(std::uint32_t sheet, float c, float r) const;
  float farthest_from_prediction(std::uint32_t c, std::uint32_t r);

  RayClassifier* classifier_;
  float tolerance_;
  std::uint32_t column_ = 0;
  std::uint32_t row_ = 0;
  std::array<TileRay, kSide * kSide> rays_;
  TileRay like_;  ///< a ray that crosses the sheets
  std::array<Sheet, TileRay::kMost> sheets_{};
  std::uint32_t guided_ = 0;
  std::uint32_t interpolated_ = 0;
};

}  // namespace plumbline
