#pragma once
/// How far off in depth a view is, as an image, and the ripple that it shows.

#include <cstdint>
#include <span>

#include "slicer/core/arena.hpp"
#include "slicer/core/vec.hpp"
#include "slicer/views/phasor.hpp"
#include "slicer/views/ripple.hpp"

namespace plumbline {

/// Which place of an image has what of a view: square cells across the view's axis.
struct DepthFrame {
  Vec3d middle = Vec3d::Zero();  ///< of the view's points, mm
  Vec3d axis = Vec3d::UnitZ();   ///< the ray there
  Vec3d right = Vec3d::UnitX();
  Vec3d up = Vec3d::UnitY();
  double reach = 1;  ///< of the image from its middle to its sides, mm

  DepthFrame() = default;
  DepthFrame(const Vec3d& centre, const Vec3d& ray, double half_side);
};

class DepthImage {
 public:
  static constexpr std::uint32_t kSide = 64;
  static constexpr std::uint32_t kCells = kSide * kSide;

  struct Cell {
    float weight = 0;
    float off = 0;    ///< sum of weight times mm along the rays
    float depth = 0;  ///< sum of weight times mm along the axis
  };

  DepthImage(const DepthFrame& frame, std::span<Cell> cells) : frame_(frame), cells_(cells) {}
  /// @param off  mm that what lies at x is too far along its ray, times weight
  void add(const Vec3d& x, double off, double weight);
  /// Fits a wave to what the image shows, least squares, and takes what it has changed by out of the image.
  /// @param frequency_too  or its amplitude and phase alone
  void fit(Wave& wave, bool frequency_too);

  std::span<const Cell> cells() const { return cells_; }
  const DepthFrame& frame() const { return frame_; }

 private:
  Vec3d place(std::uint32_t cell) const;

  DepthFrame frame_;
  std::span<Cell> cells_;
};

/// Looks for waves in depth images: peaks of their spectra.
class WaveSearch {
 public:
  static std::size_t bytes();
  static Expected<WaveSearch> create(Arena& arena);

  /// Fits a view's waves to what they have left in its image, and adds those that stand out of it.
  void improve(Ripple& ripple, DepthImage& image);

 private:
  void transform(std::span<const DepthImage::Cell> cells);
  bool strongest(const Ripple& ripple, const DepthFrame& frame, Wave& wave);

  std::span<Phasor> rows_;   ///< of the image transformed, frequencies from 0
  std::span<float> powers_;  ///< row after row, from the lowest of the frequencies upwards
  std::span<float> sorted_;  ///< the same, in the median's order
  std::span<Phasor> turns_;  ///< a whole turn in 2 kSide steps
};

}  // namespace plumbline
