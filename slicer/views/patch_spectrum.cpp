#include "slicer/views/patch_spectrum.hpp"

#include <omp.h>

#include <algorithm>
#include <array>
#include <cmath>

#include "slicer/core/numbers/lanes.hpp"
#include "slicer/core/numbers/vec.hpp"

namespace plumbline {
namespace {

/// Least power of a peak; 1 is chance. A random patch has one as high in its 200,000 samples with a probability of 2 %.
constexpr float kMinPower = 16;
// Frequencies of a peak, cycles per spacing. Many views share a patch, so the pixels of one are wider than the spacing
// of all.
constexpr float kLowest = 0.11F;
constexpr float kHighest = 0.77F;
/// Largest ratio of a peak's frequency across the patch to that in its plane. The object's own shape has steeper
/// spectra.
constexpr float kMaxSteepness = 2;
/// Step of the frequency across the patch, over 1 / its RMS depth: small enough that no peak falls between two steps.
constexpr float kAcrossStep = 0.15F;
constexpr std::uint32_t kMaxSlices = 64;  ///< steps across the patch; bounds the time of deep patches
constexpr std::size_t kCells = std::size_t{PatchSpectrum::kSide} * PatchSpectrum::kSide;
/// Largest share of a peak's power that may remain at a distance of 1 / radius. A grid's peak has fallen to nothing
/// there; a flat wall makes a streak instead.
constexpr float kMaxStreak = 0.4F;
/// Distance of two peaks, over 1 / radius: the main lobe of one point grid's peak in a disc is about as wide (0.61 to
/// its zero on either side).
constexpr float kPeakDistance = 1.2F;
/// Side of the transform over the patch's radius: the patch's diameter and a tenth of margin.
constexpr float kImageSide = 2.2F;

/// Sums exp(2 pi i <f, x>) over the points.
PLUMBLINE_WIDE void add_phasors(const float* x, const float* y, const float* z, std::size_t size, const float* f,
                                double* sums) {
  Lanes re_sum = {};
  Lanes im_sum = {};
  for (std::size_t i = 0; i < size; i += kLanes) {
    Lanes px, py, pz, re, im;
    load(px, x + i);
    load(py, y + i);
    load(pz, z + i);
    phasors(f[0] * px + f[1] * py + f[2] * pz, re, im);
    re_sum += re;
    im_sum += im;
  }
  sums[0] = static_cast<double>(sum(re_sum));
  sums[1] = static_cast<double>(sum(im_sum));
}

/// Where points lie in an image, and the turn of each.
struct DrawnPoints {
  static constexpr std::size_t kSize = 128;
  std::array<float, kSize> column, row, re, im;
};
struct PatchAxes {
  std::array<float, 3> right, up, across;  ///< the first two in cells, the last in turns
};

PLUMBLINE_WIDE void place_points(const float* x, const float* y, const float* z, std::size_t size,
                                 const PatchAxes& axes, DrawnPoints& drawn) {
  for (std::size_t i = 0; i < size; i += kLanes) {
    Lanes px, py, pz, re, im;
    load(px, x + i);
    load(py, y + i);
    load(pz, z + i);
    phasors(axes.across[0] * px + axes.across[1] * py + axes.across[2] * pz, re, im);
    store(&drawn.column[i], axes.right[0] * px + axes.right[1] * py + axes.right[2] * pz);
    store(&drawn.row[i], axes.up[0] * px + axes.up[1] * py + axes.up[2] * pz);
    store(&drawn.re[i], re);
    store(&drawn.im[i], im);
  }
}

/// Fast Fourier transform (Cooley and Tukey) of every column of an image in place.
PLUMBLINE_WIDE void transform_columns(float* re, float* im, const float* twiddles) {
  constexpr std::size_t kSide = PatchSpectrum::kSide;
  for (std::size_t i = 1, j = 0; i < kSide; ++i) {
    std::size_t bit = kSide / 2;
    for (; (j & bit) != 0; bit /= 2) j ^= bit;
    j ^= bit;
    if (i >= j) continue;
    for (std::size_t k = 0; k < kSide; ++k) {
      std::swap(re[i * kSide + k], re[j * kSide + k]);
      std::swap(im[i * kSide + k], im[j * kSide + k]);
    }
  }
  for (std::size_t length = 2; length <= kSide; length *= 2) {
    const std::size_t half = length / 2;
    for (std::size_t at = 0; at < kSide; at += length) {
      for (std::size_t k = 0; k < half; ++k) {
        const float wr = twiddles[k * (kSide / length)];
        const float wi = twiddles[kSide + k * (kSide / length)];
        float* const re_a = re + (at + k) * kSide;
        float* const im_a = im + (at + k) * kSide;
        float* const re_b = re_a + half * kSide;
        float* const im_b = im_a + half * kSide;
        for (std::size_t n = 0; n < kSide; n += kLanes) {
          Lanes ar, ai, br, bi;
          load(ar, re_a + n);
          load(ai, im_a + n);
          load(br, re_b + n);
          load(bi, im_b + n);
          const Lanes tr = br * wr - bi * wi;
          const Lanes ti = br * wi + bi * wr;
          store(re_a + n, ar + tr);
          store(im_a + n, ai + ti);
          store(re_b + n, ar - tr);
          store(im_b + n, ai - ti);
        }
      }
    }
  }
}

/// A total order, strongest first.
bool is_stronger(const SpectrumPeak& a, const SpectrumPeak& b) {
  if (a.power != b.power) return a.power > b.power;
  return std::lexicographical_compare(a.frequency.begin(), a.frequency.end(), b.frequency.begin(), b.frequency.end());
}

void transpose(float* image) {
  constexpr std::size_t kSide = PatchSpectrum::kSide;
  for (std::size_t i = 0; i < kSide; ++i) {
    for (std::size_t j = 0; j < i; ++j) std::swap(image[i * kSide + j], image[j * kSide + i]);
  }
}

}  // namespace

Phasor coefficient(const LocalPoints& points, const Vec3f& frequency) {
  std::array<double, 2> sums = {};
  add_phasors(points.x.data(), points.y.data(), points.z.data(), points.size(), frequency.data(), sums.data());
  const auto count = static_cast<double>(points.size());
  return {static_cast<float>(sums[0] / count), static_cast<float>(sums[1] / count)};
}

float power_at(const LocalPoints& points, const Vec3f& frequency) {
  const Phasor c = coefficient(points, frequency);
  return (c.re * c.re + c.im * c.im) * static_cast<float>(points.size());
}

std::size_t PatchSpectrum::bytes(std::uint32_t threads) {
  return 2 * (threads * kCells + kSide) * sizeof(float) + (kMaxCandidates + kMaxPeaks) * sizeof(SpectrumPeak);
}

Expected<PatchSpectrum> PatchSpectrum::create(Arena& arena) {
  PatchSpectrum spectrum;
  const auto threads = static_cast<std::size_t>(omp_get_max_threads());
  PLUMBLINE_TRY(arena.take_top(spectrum.images_, threads * 2 * kCells, "views"));
  PLUMBLINE_TRY(arena.take_top(spectrum.twiddles_, 2 * kSide, "views"));
  PLUMBLINE_TRY(arena.take_top(spectrum.candidates_, kMaxCandidates, "views"));
  PLUMBLINE_TRY(arena.take_top(spectrum.peaks_, kMaxPeaks, "views"));
  for (std::uint32_t k = 0; k < kSide; ++k) {
    const Phasor w = phasor(-static_cast<float>(k) / static_cast<float>(kSide));
    spectrum.twiddles_[k] = w.re;
    spectrum.twiddles_[kSide + k] = w.im;
  }
  return spectrum;
}

/// Keeps the strongest, in whatever order they are added.
void PatchSpectrum::add(const SpectrumPeak& peak) {
  if (candidate_count_ < kMaxCandidates) {
    candidates_[candidate_count_++] = peak;
    return;
  }
  const auto weakest = std::max_element(candidates_.begin(), candidates_.end(), is_stronger);
  if (is_stronger(peak, *weakest)) *weakest = peak;
}

/// Adds the peaks of one slice. Frequencies are in the frame of the patch: x and y in its plane, z across.
void PatchSpectrum::find_peaks(float across, float cell, std::size_t count, const Image& image) {
  const auto power = [&](std::uint32_t x, std::uint32_t y) {
    const std::size_t i = std::size_t{x % kSide} * kSide + y % kSide;
    return image.re[i] * image.re[i] + image.im[i] * image.im[i];
  };
  const float least = kMinPower * static_cast<float>(count);
  const float step = 1 / (cell * static_cast<float>(kSide));
  const auto signed_index = [](std::uint32_t i) {
    return i < kSide / 2 ? static_cast<float>(i) : static_cast<float>(i) - static_cast<float>(kSide);
  };
  for (std::uint32_t x = 0; x < kSide; ++x) {
    for (std::uint32_t y = 0; y < kSide; ++y) {
      const float here = power(x, y);
      if (here < least) continue;
      const Vec3f f(signed_index(x) * step, signed_index(y) * step, across);
      const float in_plane = std::sqrt(f[0] * f[0] + f[1] * f[1]);
      const float all = std::sqrt(f.dot(f));
      if (all < lowest_ || all > highest_ || in_plane * kMaxSteepness < across) continue;
      bool highest = true;
      for (const std::uint32_t dy : {kSide - 1, 0U, 1U}) {
        for (const std::uint32_t dx : {kSide - 1, 0U, 1U}) {
          if ((dx != 0 || dy != 0) && power(x + dx, y + dy) > here) highest = false;
        }
      }
      if (!highest) continue;
#pragma omp critical(patch_spectrum_add)
      add({f, here / static_cast<float>(count)});
    }
  }
}

/// Draws each point into the image, spread over four cells and turned by its phase at a frequency across the patch.
void PatchSpectrum::draw(const LocalPoints& points, const Vec3f& normal, float across, float cell, const Image& image) {
  const Frame frame(normal);
  PatchAxes axes = {};
  for (std::size_t k = 0; k < 3; ++k) {
    const auto axis = static_cast<Eigen::Index>(k);
    axes.right[k] = frame.t[axis] / cell;
    axes.up[k] = frame.s[axis] / cell;
    axes.across[k] = -across * normal[axis];
  }
  std::fill(image.re.begin(), image.re.end(), 0.0F);
  std::fill(image.im.begin(), image.im.end(), 0.0F);
  constexpr float kMiddle = static_cast<float>(kSide) / 2;
  DrawnPoints drawn;
  for (std::size_t first = 0; first < points.size(); first += DrawnPoints::kSize) {
    const std::size_t size = std::min(DrawnPoints::kSize, points.size() - first);
    place_points(&points.x[first], &points.y[first], &points.z[first], size, axes, drawn);
    for (std::size_t i = 0; i < size; ++i) {
      const float x = drawn.column[i] + kMiddle;
      const float y = drawn.row[i] + kMiddle;
      if (!(x >= 0 && y >= 0 && x < kSide - 1 && y < kSide - 1)) continue;
      const auto column = static_cast<std::size_t>(x);
      const auto row = static_cast<std::size_t>(y);
      const float u = x - static_cast<float>(column);
      const float v = y - static_cast<float>(row);
      const auto put = [&](std::size_t at, float weight) {
        image.re[at] += weight * drawn.re[i];
        image.im[at] += weight * drawn.im[i];
      };
      put(row * kSide + column, (1 - u) * (1 - v));
      put(row * kSide + column + 1, u * (1 - v));
      put((row + 1) * kSide + column, (1 - u) * v);
      put((row + 1) * kSide + column + 1, u * v);
    }
  }
}

/// Adds the peaks at one frequency across the patch. Runs in several threads.
void PatchSpectrum::transform_slice(const LocalPoints& points, const Vec3f& normal, float across, float cell) {
  const auto thread = static_cast<std::size_t>(omp_get_thread_num());
  const Image image{images_.subspan(thread * 2 * kCells, kCells), images_.subspan((thread * 2 + 1) * kCells, kCells)};
  draw(points, normal, across, cell, image);
  transform_columns(image.re.data(), image.im.data(), twiddles_.data());
  transpose(image.re.data());
  transpose(image.im.data());
  transform_columns(image.re.data(), image.im.data(), twiddles_.data());
  find_peaks(across, cell, points.size(), image);
}

std::span<const SpectrumPeak> PatchSpectrum::peaks(const LocalPoints& points, const Vec3f& normal, float radius,
                                                   float spacing) {
  const Frame frame(normal);
  candidate_count_ = 0;
  lowest_ = kLowest / spacing;
  highest_ = kHighest / spacing;
  double depth2 = 0;
  for (std::size_t i = 0; i < points.size(); ++i) {
    const double w = static_cast<double>(normal.dot(points[i]));
    depth2 += w * w;
  }
  const auto depth = static_cast<float>(std::sqrt(depth2 / static_cast<double>(points.size())));
  const float steepest = highest_ * kMaxSteepness / std::sqrt(1 + kMaxSteepness * kMaxSteepness);
  const float step = std::max(kAcrossStep / std::max(depth, 1e-6F * radius), steepest / kMaxSlices);
  const float cell = kImageSide * radius / static_cast<float>(kSide);
  std::array<float, kMaxSlices + 2> slices;  // NOLINT(cppcoreguidelines-pro-type-member-init)
  std::size_t count = 0;
  for (float across = 0; across <= steepest && count < slices.size(); across += step) slices[count++] = across;
#pragma omp parallel for schedule(dynamic)
  for (std::size_t s = 0; s < count; ++s) transform_slice(points, normal, slices[s], cell);
  const auto found = candidates_.first(candidate_count_);
  std::sort(found.begin(), found.end(), is_stronger);
  const float apart = kPeakDistance / radius;
  std::uint32_t kept = 0;
  const auto is_near_kept = [&](const Vec3f& f) {
    return std::any_of(peaks_.begin(), peaks_.begin() + kept, [&](const SpectrumPeak& p) {
      const Vec3f d = p.frequency - f;
      const Vec3f e = p.frequency + f;
      return std::min(d.dot(d), e.dot(e)) < apart * apart;
    });
  };
  // As many at once as there are threads, so that one thread looks at none in vain.
  struct Tried {
    SpectrumPeak peak;
    float in_plane;
    bool streak;
  };
  std::array<Tried, kMaxPeaks> tried;  // NOLINT(cppcoreguidelines-pro-type-member-init)
  const std::size_t at_once = std::min<std::size_t>(kMaxPeaks, static_cast<std::size_t>(omp_get_max_threads()));
  for (auto next = found.begin(); next != found.end() && kept < kMaxPeaks;) {
    std::size_t trying = 0;
    for (; next != found.end() && trying < at_once; ++next) {
      const Vec3f& c = next->frequency;
      const Vec3f f = frame.t * c[0] + frame.s * c[1] + normal * c[2];
      if (!is_near_kept(f)) tried[trying++] = {{f, next->power}, std::sqrt(c[0] * c[0] + c[1] * c[1]), false};
    }
#pragma omp parallel for schedule(static)
    for (Tried& t : std::span(tried).first(trying)) {
      const Vec3f& f = t.peak.frequency;
      const Vec3f aside = f / (radius * t.in_plane);
      const float most = kMaxStreak * power_at(points, f);
      t.streak = power_at(points, f + aside) > most && power_at(points, f - aside) > most;
    }
    for (const Tried& t : std::span(tried).first(trying)) {
      if (!t.streak && kept < kMaxPeaks && !is_near_kept(t.peak.frequency)) peaks_[kept++] = t.peak;
    }
  }
  // Move from the nearest sample to the top of each peak, in steps that halve.
  const std::array<Vec3f, 3> directions = {frame.t * (0.25F * apart), frame.s * (0.25F * apart),
                                           normal * (0.5F * step)};
#pragma omp parallel for schedule(dynamic)
  for (std::size_t k = 0; k < kept; ++k) climb(peaks_[k], points, directions);
  return peaks_.first(kept);
}

void PatchSpectrum::climb(SpectrumPeak& peak, const LocalPoints& points, std::span<const Vec3f> directions) {
  peak.power = power_at(points, peak.frequency);
  for (float scale = 1; scale > 0.05F; scale *= 0.5F) {
    for (const Vec3f& direction : directions) {
      for (const float sign : {-1.0F, 1.0F}) {
        const Vec3f f = peak.frequency + direction * (sign * scale);
        const float there = power_at(points, f);
        if (there > peak.power) peak = {f, there};
      }
    }
  }
}

}  // namespace plumbline
