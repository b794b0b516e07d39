#pragma once
/// The spectrum of a patch of a scan, which shows the grids that its points lie on.

#include <cstdint>
#include <span>

#include "slicer/core/arena.hpp"
#include "slicer/core/numbers/vec.hpp"
#include "slicer/views/local_points.hpp"
#include "slicer/views/phasor.hpp"

namespace plumbline {

/// A frequency at which the points of a patch are periodic.
struct SpectrumPeak {
  Vec3f frequency = Vec3f::Zero();  ///< cycles per mm, in the axes of the points
  float power = 0;                  ///< |sum of exp(-2 pi i <f, x>)|^2 over the number of points; 1 for random points
};

/// Mean of exp(2 pi i <f, x>) over the points.
[[nodiscard]] Phasor coefficient(const LocalPoints& points, const Vec3f& frequency);
/// SpectrumPeak::power of one frequency.
[[nodiscard]] float power_at(const LocalPoints& points, const Vec3f& frequency);

/// Finds the peaks of the spectrum in three dimensions.
///
/// The points of a view lie on a grid of rays, and noise moves them along the rays. Across the rays they are periodic
/// whatever the noise: the spectrum has peaks at the two reciprocal vectors of the grid and at their sums. The patch is
/// nearly flat, so a 2D Fourier transform in its plane is taken for each of a few frequencies across it.
class PatchSpectrum {
 public:
  /// Samples of the transform a side. At the radius of the smallest patch a sample is 0.62 spacings wide, so that the
  /// highest frequency looked for, 0.77 / spacing, stays below the transform's limit of 0.81 / spacing.
  static constexpr std::uint32_t kSide = 128;

  /// Upper bound of the arena bytes that create() takes, without alignment.
  static std::size_t bytes(std::uint32_t threads);
  static Expected<PatchSpectrum> create(Arena& arena);

  /// @param points   relative to the middle of the patch, mm
  /// @param normal   unit normal of the patch
  /// @param radius   of the patch, mm
  /// @param spacing  of its points, mm; peaks are searched from 0.11 / spacing to 0.77 / spacing
  /// @returns peaks of falling power, no two closer than 1.2 / radius; valid until the next call
  std::span<const SpectrumPeak> peaks(const LocalPoints& points, const Vec3f& normal, float radius, float spacing);

 private:
  static constexpr std::uint32_t kMaxPeaks = 24;
  static constexpr std::uint32_t kMaxCandidates = 512;

  /// Real and imaginary parts, row after row. After the transform a row is a column of frequencies.
  struct Image {
    std::span<float> re, im;
  };

  void transform_slice(const LocalPoints& points, const Vec3f& normal, float across, float cell);
  static void draw(const LocalPoints& points, const Vec3f& normal, float across, float cell, const Image& image);
  void find_peaks(float across, float cell, std::size_t count, const Image& image);
  static void climb(SpectrumPeak& peak, const LocalPoints& points, std::span<const Vec3f> directions);
  void add(const SpectrumPeak& peak);

  std::span<float> images_;    ///< of each thread: real parts, imaginary parts
  std::span<float> twiddles_;  ///< exp(-2 pi i k / kSide), real then imaginary
  std::span<SpectrumPeak> candidates_;
  std::span<SpectrumPeak> peaks_;
  std::uint32_t candidate_count_ = 0;
  float lowest_ = 0, highest_ = 0;  ///< cycles per mm
};

}  // namespace plumbline
