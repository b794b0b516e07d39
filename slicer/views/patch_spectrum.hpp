#pragma once
/// The spectrum of a patch of a scan: what grids its points lie on.

#include <cstdint>
#include <span>

#include "slicer/core/arena.hpp"
#include "slicer/core/vec.hpp"
#include "slicer/views/phasor.hpp"

namespace plumbline {

/// A frequency at which the points of a patch are periodic.
struct SpectrumPeak {
  Vec3f frequency = Vec3f::Zero();  ///< cycles per mm, in the axes of the points
  float power = 0;  ///< |sum of exp(-2 pi i <f, x>)|^2 over the number of points; 1 for points without order
};

/// Sum of exp(2 pi i <f, x>) over the points, over their number.
[[nodiscard]] Phasor coefficient(std::span<const Vec3f> points, const Vec3f& frequency);
/// SpectrumPeak::power of one frequency.
[[nodiscard]] float power_at(std::span<const Vec3f> points, const Vec3f& frequency);

/// Finds the peaks of the spectrum in three dimensions.
///
/// A scanner's view has its points on a grid of rays, and noise moves them along the rays. So across the rays they are
/// periodic whatever the noise: peaks at the two reciprocal vectors of the grid and their sums. The patch is nearly flat, so
/// that in its plane a discrete Fourier transform is taken, for each of a few frequencies across it.
class PatchSpectrum {
 public:
  static constexpr std::uint32_t kSide = 128;  ///< samples of the transform a side

  /// Bytes of arena that create() takes, rounding of blocks apart.
  static std::size_t bytes();
  static Expected<PatchSpectrum> create(Arena& arena);

  /// @param points   relative to the middle of the patch, mm
  /// @param normal   of the patch, a unit vector
  /// @param radius   of the patch, mm
  /// @param spacing  of its points, mm: peaks are looked for from 0.11 / spacing to 0.77 / spacing
  /// @returns the highest peaks first; no two of them closer than 1.2 / radius
  std::span<const SpectrumPeak> peaks(std::span<const Vec3f> points, const Vec3f& normal, float radius, float spacing);

 private:
  static constexpr std::uint32_t kMostPeaks = 24;
  static constexpr std::uint32_t kMostCandidates = 512;

  void transform();
  void transform_line(Phasor* line) const;
  void look_for_peaks(float across, float cell, std::size_t count);
  void add(const SpectrumPeak& peak);

  std::span<Phasor> image_;
  std::span<Phasor> twiddles_;
  std::span<SpectrumPeak> candidates_;
  std::span<SpectrumPeak> peaks_;
  std::uint32_t candidate_count_ = 0;
  float lowest_ = 0, highest_ = 0;  ///< cycles per mm
};

}  // namespace plumbline
