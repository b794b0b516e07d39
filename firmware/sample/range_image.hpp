#pragma once
/// The range image that one station of the virtual scanner takes of the bust.

#include <algorithm>
#include <cmath>
#include <cstddef>
#include <cstdint>
#include <vector>

#include "firmware/sample/counter_rng.hpp"
#include "slicer/core/numbers/vec.hpp"

namespace plumbline::firmware {

/// A station: camera and projector, looking at the bust. mm.
struct Station {
  Vec3d middle;  ///< of the bust
  Vec3d eye, projector;
  Vec3d right, up, forward;                             ///< unit vectors; forward looks at the bust
  Vec3d shift = Vec3d::Zero();                          ///< misregistration
  Vec3d rotation = Vec3d::Zero();                       ///< misregistration about the middle, radians
  double low_u = 0, high_u = 0, low_v = 0, high_v = 0;  ///< window along right and up, at the distance of the middle
};

inline constexpr double kStationDistance = 350.0;  ///< camera to the middle of the bust, mm
inline constexpr double kBoundingRadius = 38.0;    ///< of the bust about its middle, mm

enum class PixelState : std::uint8_t {
  kNothing,  ///< the ray passes by
  kSeen,     ///< the camera sees the bust
  kKept,     ///< camera and projector see it, and the point was not lost
};

/// Ranges along rays through a grid of pixel centres, row by row from below.
class RangeImage {
 public:
  /// @param pitch  of the pixels, mm at the distance of the middle
  RangeImage(const Station& view, double pitch)
      : view_(view),
        pitch_(pitch),
        columns_(static_cast<std::size_t>((view.high_u - view.low_u) / pitch) + 2),
        rows_(static_cast<std::size_t>((view.high_v - view.low_v) / pitch) + 2) {
    range_.assign(columns_ * rows_, 0.0);
    state_.assign(columns_ * rows_, PixelState::kNothing);
  }

  std::size_t columns() const { return columns_; }
  std::size_t rows() const { return rows_; }
  std::size_t index(std::size_t i, std::size_t j) const { return j * columns_ + i; }
  bool seen(std::size_t pixel) const { return state_[pixel] != PixelState::kNothing; }
  PixelState state(std::size_t pixel) const { return state_[pixel]; }
  double range(std::size_t pixel) const { return range_[pixel]; }  ///< mm from the eye

  Vec3d direction(double i, double j) const {
    const double u = view_.low_u + (i + 0.5) * pitch_, v = view_.low_v + (j + 0.5) * pitch_;
    return (kStationDistance * view_.forward + u * view_.right + v * view_.up).normalized();
  }
  Vec3d direction(std::size_t i, std::size_t j) const { return direction(double(i), double(j)); }
  Vec3d point(std::size_t i, std::size_t j) const { return view_.eye + range_[index(i, j)] * direction(i, j); }

  /// Whether the depth jumps between two seen pixels, so that no surface connects them.
  bool jump(std::size_t a, std::size_t b) const {
    return std::abs(range_[a] - range_[b]) > std::max(4.0 * pitch_, 0.4);
  }

  /// Finds the range of every pixel of the rows [first, first + kTile).
  void trace_band(std::size_t first);
  /// Decides which pixels both camera and projector see. All rows must have been traced.
  /// @returns their number
  std::size_t select(const CounterRng& rng);
  /// Adds noise, more where the surface turns away. Call after select().
  void add_noise(const CounterRng& rng);
  /// Unit normal from cross products over the neighbourhood; faces the camera.
  Vec3d normal(std::size_t i, std::size_t j) const;

  static constexpr std::size_t kTile = 8;

 private:
  double trace(const Vec3d& direction, double from) const;
  bool lit(const Vec3d& p, const Vec3d& normal) const;
  bool local_normal(std::size_t i, std::size_t j, Vec3d& normal) const;

  static constexpr double kNear = kStationDistance - kBoundingRadius, kFarEnd = kStationDistance + kBoundingRadius;
  static constexpr double kHit = 5e-4;  // a range is exact to that

  Station view_;
  double pitch_;
  std::size_t columns_ = 0, rows_ = 0;
  std::vector<double> range_;
  std::vector<float> cosine_;
  std::vector<PixelState> state_;
};

}  // namespace plumbline::firmware
