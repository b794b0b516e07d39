#include "slicer/views/patch_spectrum.hpp"

#include <algorithm>
#include <array>
#include <cmath>

#include "slicer/core/vec.hpp"

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
/// Largest share of a peak's power that may remain at a distance of 1 / radius. A grid's peak has fallen to nothing
/// there; a flat wall makes a streak instead.
constexpr float kMaxStreak = 0.4F;
/// Distance of two peaks, over 1 / radius: the main lobe of one point grid's peak in a disc is about as wide (0.61 to
/// its zero on either side).
constexpr float kPeakDistance = 1.2F;
/// Side of the transform over the patch's radius: the patch's diameter and a tenth of margin.
constexpr float kImageSide = 2.2F;

}  // namespace

Phasor coefficient(std::span<const Vec3f> points, const Vec3f& frequency) {
  double re = 0;
  double im = 0;
  for (const Vec3f& p : points) {
    const Phasor t = phasor(frequency.dot(p));
    re += static_cast<double>(t.re);
    im += static_cast<double>(t.im);
  }
  const auto count = static_cast<double>(points.size());
  return {static_cast<float>(re / count), static_cast<float>(im / count)};
}

float power_at(std::span<const Vec3f> points, const Vec3f& frequency) {
  const Phasor c = coefficient(points, frequency);
  return (c.re * c.re + c.im * c.im) * static_cast<float>(points.size());
}

std::size_t PatchSpectrum::bytes() {
  return (std::size_t{kSide} * kSide + kSide) * sizeof(Phasor) + (kMaxCandidates + kMaxPeaks) * sizeof(SpectrumPeak);
}

Expected<PatchSpectrum> PatchSpectrum::create(Arena& arena) {
  PatchSpectrum spectrum;
  auto image = arena.take_top<Phasor>(std::size_t{kSide} * kSide, "views");
  PLUMBLINE_TRY(image);
  auto twiddles = arena.take_top<Phasor>(kSide, "views");
  PLUMBLINE_TRY(twiddles);
  auto candidates = arena.take_top<SpectrumPeak>(kMaxCandidates, "views");
  PLUMBLINE_TRY(candidates);
  auto peaks = arena.take_top<SpectrumPeak>(kMaxPeaks, "views");
  PLUMBLINE_TRY(peaks);
  spectrum.image_ = *image;
  spectrum.twiddles_ = *twiddles;
  spectrum.candidates_ = *candidates;
  spectrum.peaks_ = *peaks;
  for (std::uint32_t k = 0; k < kSide; ++k) {
    spectrum.twiddles_[k] = phasor(-static_cast<float>(k) / static_cast<float>(kSide));
  }
  return spectrum;
}

/// Fast Fourier transform (Cooley and Tukey) of kSide values in place.
void PatchSpectrum::transform_line(Phasor* line) const {
  for (std::uint32_t i = 1, j = 0; i < kSide; ++i) {
    std::uint32_t bit = kSide / 2;
    for (; (j & bit) != 0; bit /= 2) j ^= bit;
    j ^= bit;
    if (i < j) std::swap(line[i], line[j]);
  }
  for (std::uint32_t length = 2; length <= kSide; length *= 2) {
    const std::uint32_t half = length / 2;
    const std::uint32_t stride = kSide / length;
    for (std::uint32_t at = 0; at < kSide; at += length) {
      for (std::uint32_t k = 0; k < half; ++k) {
        const Phasor w = twiddles_[k * stride];
        Phasor& a = line[at + k];
        Phasor& b = line[at + k + half];
        const Phasor turned{b.re * w.re - b.im * w.im, b.re * w.im + b.im * w.re};
        b = {a.re - turned.re, a.im - turned.im};
        a = {a.re + turned.re, a.im + turned.im};
      }
    }
  }
}

void PatchSpectrum::transform() {
  for (std::uint32_t row = 0; row < kSide; ++row) transform_line(&image_[std::size_t{row} * kSide]);
  std::array<Phasor, kSide> line;  // NOLINT(cppcoreguidelines-pro-type-member-init)
  for (std::uint32_t column = 0; column < kSide; ++column) {
    for (std::uint32_t row = 0; row < kSide; ++row) line[row] = image_[std::size_t{row} * kSide + column];
    transform_line(line.data());
    for (std::uint32_t row = 0; row < kSide; ++row) image_[std::size_t{row} * kSide + column] = line[row];
  }
}

void PatchSpectrum::add(const SpectrumPeak& peak) {
  if (candidate_count_ < kMaxCandidates) {
    candidates_[candidate_count_++] = peak;
    return;
  }
  auto least = std::min_element(candidates_.begin(), candidates_.end(),
                                [](const SpectrumPeak& a, const SpectrumPeak& b) { return a.power < b.power; });
  if (least->power < peak.power) *least = peak;
}

/// Adds the peaks of one slice. Frequencies are in the frame of the patch: x and y in its plane, z across.
void PatchSpectrum::find_peaks(float across, float cell, std::size_t count) {
  const auto power = [&](std::uint32_t x, std::uint32_t y) {
    const Phasor& p = image_[std::size_t{y % kSide} * kSide + x % kSide];
    return p.re * p.re + p.im * p.im;
  };
  const float least = kMinPower * static_cast<float>(count);
  const float step = 1 / (cell * static_cast<float>(kSide));
  const auto signed_index = [](std::uint32_t i) {
    return i < kSide / 2 ? static_cast<float>(i) : static_cast<float>(i) - static_cast<float>(kSide);
  };
  for (std::uint32_t y = 0; y < kSide; ++y) {
    for (std::uint32_t x = 0; x < kSide; ++x) {
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
      if (highest) add({f, here / static_cast<float>(count)});
    }
  }
}

std::span<const SpectrumPeak> PatchSpectrum::peaks(std::span<const Vec3f> points, const Vec3f& normal, float radius,
                                                   float spacing) {
  const Frame frame(normal);
  candidate_count_ = 0;
  lowest_ = kLowest / spacing;
  highest_ = kHighest / spacing;
  double depth2 = 0;
  for (const Vec3f& p : points) {
    const double w = static_cast<double>(normal.dot(p));
    depth2 += w * w;
  }
  const auto depth = static_cast<float>(std::sqrt(depth2 / static_cast<double>(points.size())));
  const float steepest = highest_ * kMaxSteepness / std::sqrt(1 + kMaxSteepness * kMaxSteepness);
  const float step = std::max(kAcrossStep / std::max(depth, 1e-6F * radius), steepest / kMaxSlices);
  const float cell = kImageSide * radius / static_cast<float>(kSide);
  const auto side = static_cast<float>(kSide);
  for (float across = 0; across <= steepest; across += step) {
    std::fill(image_.begin(), image_.end(), Phasor{0, 0});
    for (const Vec3f& p : points) {
      const float x = frame.t.dot(p) / cell + side / 2;
      const float y = frame.s.dot(p) / cell + side / 2;
      const float left = std::floor(x);
      const float low = std::floor(y);
      if (!(left >= 0 && low >= 0 && left < side - 1 && low < side - 1)) continue;
      const Phasor turn = phasor(-across * normal.dot(p));
      const auto column = static_cast<std::size_t>(left);
      const auto row = static_cast<std::size_t>(low);
      const float u = x - left;
      const float v = y - low;
      const auto put = [&](std::size_t at, float weight) {
        image_[at].re += weight * turn.re;
        image_[at].im += weight * turn.im;
      };
      put(row * kSide + column, (1 - u) * (1 - v));
      put(row * kSide + column + 1, u * (1 - v));
      put((row + 1) * kSide + column, (1 - u) * v);
      put((row + 1) * kSide + column + 1, u * v);
    }
    transform();
    find_peaks(across, cell, points.size());
  }
  const auto found = candidates_.first(candidate_count_);
  std::sort(found.begin(), found.end(), [](const SpectrumPeak& a, const SpectrumPeak& b) {
    if (a.power != b.power) return a.power > b.power;
    return std::lexicographical_compare(a.frequency.begin(), a.frequency.end(), b.frequency.begin(), b.frequency.end());
  });
  const float apart = kPeakDistance / radius;
  std::uint32_t kept = 0;
  for (const SpectrumPeak& c : found) {
    const Vec3f f = frame.t * c.frequency[0] + frame.s * c.frequency[1] + normal * c.frequency[2];
    const auto near = [&](const SpectrumPeak& p) {
      const Vec3f d = p.frequency - f;
      const Vec3f e = p.frequency + f;
      return std::min(d.dot(d), e.dot(e)) < apart * apart;
    };
    if (std::any_of(peaks_.begin(), peaks_.begin() + kept, near)) continue;
    const float in_plane = std::sqrt(c.frequency[0] * c.frequency[0] + c.frequency[1] * c.frequency[1]);
    const float here = power_at(points, f);
    const Vec3f aside = f / (radius * in_plane);
    if (std::min(power_at(points, f + aside), power_at(points, f - aside)) > kMaxStreak * here) continue;
    peaks_[kept++] = {f, c.power};
    if (kept == kMaxPeaks) break;
  }
  // Move from the nearest sample to the top of each peak, in steps that halve.
  const std::array<Vec3f, 3> directions = {frame.t * (0.25F * apart), frame.s * (0.25F * apart),
                                           normal * (0.5F * step)};
  for (SpectrumPeak& p : peaks_.first(kept)) {
    p.power = power_at(points, p.frequency);
    for (float scale = 1; scale > 0.05F; scale *= 0.5F) {
      for (const Vec3f& direction : directions) {
        for (const float sign : {-1.0F, 1.0F}) {
          const Vec3f f = p.frequency + direction * (sign * scale);
          const float there = power_at(points, f);
          if (there > p.power) p = {f, there};
        }
      }
    }
  }
  return peaks_.first(kept);
}

}  // namespace plumbline
