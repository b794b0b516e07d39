#pragma once
/// Proves an R-Rep against points of the scan that it was made from: how far from its surface do they lie?

#include <cstdint>
#include <span>

#include "slicer/cloud/proof_sample.hpp"
#include "slicer/core/numbers/vec.hpp"
#include "slicer/core/words/told.hpp"
#include "slicer/rrep/crossing_store.hpp"

namespace plumbline::inline slicer {

/// How far points of the scan lie from the surface of the R-Rep.
struct PointProof {
  std::uint32_t points = 0;        ///< 0: nothing to prove, as of a mesh
  std::uint32_t within_pixel = 0;  ///< a pixel pitch, the larger one
  std::uint32_t within_layer = 0;  ///< a layer height
  std::uint32_t off = 0;           ///< farther away than `reach_mm`
  float reach_mm = 0;

  /// Share that may be off without a question. Real scans keep .014, simulated bad ones .03.
  static constexpr double kMostUsual = 0.05;
  /// Share above which nothing is printed: it would not be what was scanned.
  static constexpr double kMost = 2.0 / 3;

  bool is_doubtful() const { return share_off() > kMostUsual; }
  double share_off() const { return points > 0 ? static_cast<double>(off) / points : 0; }
};

/// What is told of points that are off.
Told told_off(const PointProof& proof);

/// Looks at the rays around each point, which takes time for 25 of them and no memory.
/// @param points    print coordinates, mm
/// @param reach_mm  a point that lies farther away is off; but never less than two pixels or two layers
PointProof prove(const CrossingStore& store, std::span<const Vec3f> points, float reach_mm);

}  // namespace plumbline::inline slicer
