#pragma once
/// The pixel grid of a view: where a point of the scan lies in the view's image.

#include <array>
#include <cstddef>
#include <cstdint>
#include <optional>
#include <span>

#include "slicer/core/numbers/vec.hpp"
#include "slicer/views/local_points.hpp"

namespace plumbline {

/// Radial distortion of a lens (Brown, Close-range camera calibration, 1971): what a pinhole would show at s is seen at
/// s + U ((k1 r^2 + k2 r^4 + k3 r^6) w - Q(w)), with w = (s - centre) / U, r = |w|, U = kUnit and k = radial.
/// Q(w) = (3 lu wu^2 + 2 lv wu wv + lu wv^2, lv wu^2 + 2 lu wu wv + 3 lv wv^2), with (lu, lv) = lean, is the change if the centre
/// moves by U lean / k1. It stands for the centre while k1 is too small to tell where that is.
struct Lens {
  static constexpr double kUnit = 256;  ///< pixels
  std::array<double, 3> radial = {};    ///< positive ones move pixels outwards
  Eigen::Vector2d centre = {0, 0};      ///< pixels
  Eigen::Vector2d lean = {0, 0};
};

/// Projection of a point to pixels: a pinhole's, s = ((a0 + <a, x>) / q, (b0 + <b, x>) / q) with q = 1 + <c, x>, then the lens's.
/// Points of the view have integer pixels. With c = 0 and no lens this is a scanner that sweeps in parallel.
struct ViewGrid {
  static constexpr int kUnknowns = 16;  ///< of map and lens; the centre moves by way of the lean

  Vec3f middle = Vec3f::Zero();           ///< origin of x, mm
  Eigen::Matrix<double, 11, 1> map = {};  ///< a, a0, b, b0, c; pixels per mm, pixels, 1/mm
  Lens lens;

  struct Pixel {
    double u, v;    ///< where the camera sees the point
    double su, sv;  ///< where a pinhole would
    double q;
  };
  /// @returns q = 0 for points behind the camera
  Pixel project(const Vec3f& point) const;
  /// Unit vector along the ray that the point was seen on; its sign is arbitrary.
  Vec3d ray(const Vec3f& point) const;
  /// The same projection with another origin, which must be in front of the camera.
  ViewGrid around(const Vec3f& other) const;
};

/// Counts the points (relative to the grid's middle) that lie within each of up to eight distances (below 1 pixel) of the grid.
void count_near(const ViewGrid& grid, const LocalPoints& points, std::span<const double> widths,
                std::span<std::uint32_t> counts);

/// Sets the squared distance of each point (in the scan's own frame) from the nearest integer pixel, pixels^2; 1 for points behind
/// the camera or farther than `radius` (mm) from the grid's middle.
/// @param distances2  as many as points, rounded up to a multiple of kLanes
void distances2_within(const ViewGrid& grid, double radius, std::span<const Vec3f> points, std::span<float> distances2);

/// Fits grids to points, not all of which belong to the view.
class ViewGridFit {
 public:
  static constexpr std::size_t kMaxPoints = 8192;  ///< a view with a fiftieth of them still has 160

  /// @param extent  half the size of the scan, mm: scale of the priors that keep perspective and distortion small where the points
  ///                don't determine them
  /// @param room    three times kMaxPoints numbers
  ViewGridFit(double extent, std::span<float> room) : extent_(extent), room_(room) {}

  /// Expects all further lenses to have about this first coefficient.
  void expect_lens(double radial) { radial_ = radial; }

  /// One Gauss-Newton step. Each point has Tukey's biweight of its distance from the grid.
  ///
  /// @param points  within `radius` (mm) of the grid's middle, kMaxPoints at most
  /// @param width   pixels; points farther from the grid don't count
  /// @returns how far the step moved the grid at the points, RMS in pixels; nothing, with `grid` unchanged, if the points don't
  /// determine a step
  std::optional<double> improve(ViewGrid& grid, const LocalPoints& points, double radius, double width) const;

 private:
  double extent_;
  std::optional<double> radial_;
  std::span<float> room_;
};

}  // namespace plumbline
