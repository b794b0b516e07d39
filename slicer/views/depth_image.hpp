#pragma once
/// Depth residuals of a view as an image, and the ripple in it.

#include <cstdint>
#include <span>

#include "slicer/core/arena.hpp"
#include "slicer/core/numbers/vec.hpp"
#include "slicer/views/phasor.hpp"
#include "slicer/views/ripple.hpp"

namespace plumbline {

/// Coordinate frame of a view's depth image: square cells across the view's axis.
struct DepthFrame {
  Vec3d middle = Vec3d::Zero();  ///< of the view's points, mm
  Vec3d axis = Vec3d::UnitZ();   ///< direction of the ray at `middle`
  Vec3d right = Vec3d::UnitX();
  Vec3d up = Vec3d::UnitY();
  double half_side = 1;  ///< of the image, mm

  DepthFrame() = default;
  DepthFrame(const Vec3d& centre, const Vec3d& ray, double half_side_mm);
};

class DepthImage {
 public:
  /// Cells a side. Finds as much as 96 cells did, and leaves more room for points in a small arena.
  static constexpr std::uint32_t kSide = 64;
  static constexpr std::uint32_t kCells = kSide * kSide;

  struct Cell {
    float weight = 0;
    float offset = 0;  ///< sum of weight times offset along the rays, mm
    float depth = 0;   ///< sum of weight times position along the axis, mm
  };

  DepthImage(const DepthFrame& frame, std::span<Cell> cells) : frame_(frame), cells_(cells) {}
  /// @param x       where the point was seen, mm from the middle of the scan
  /// @param offset  weight times the distance (mm) that it lies too far along its ray
  void add(const Vec3d& x, double offset, double weight);
  /// Improves a wave, about the middle of the frame, by one least-squares step, and subtracts the change from the image.
  /// @param fit_frequency  false fits only amplitude and phase
  void fit(Wave& wave, bool fit_frequency);

  std::span<const Cell> cells() const { return cells_; }
  const DepthFrame& frame() const { return frame_; }

 private:
  Vec3d place(std::uint32_t cell) const;

  DepthFrame frame_;
  std::span<Cell> cells_;
};

/// Finds waves in depth images: peaks of their spectra.
class WaveSearch {
 public:
  static std::size_t bytes();  ///< of the arena that create() takes
  static Expected<WaveSearch> create(Arena& arena);

  /// Fits the known waves of a view to what is left of them in its image, and adds waves that stand out.
  void improve(Ripple& ripple, DepthImage& image);

 private:
  void transform(std::span<const DepthImage::Cell> cells);
  bool find_strongest(const Ripple& ripple, const DepthFrame& frame, Wave& wave);

  std::span<float> rows_;    ///< Fourier transform of each row, frequencies from 0: real parts, imaginary parts
  std::span<float> powers_;  ///< of the spectrum, row after row, from the lowest vertical frequency
  std::span<float> sorted_;  ///< copy of the powers for the median
  std::span<float> turns_;   ///< the same of a 1 in each column
};

}  // namespace plumbline
