#include "slicer/views/depth_image.hpp"

#include <Eigen/Cholesky>
#include <algorithm>
#include <array>
#include <cmath>
#include <numbers>

#include "slicer/core/numbers/lanes.hpp"
#include "slicer/core/numbers/median.hpp"
#include "slicer/core/numbers/vec.hpp"

namespace plumbline {
namespace {

constexpr const char* kStage = "views";

constexpr std::uint32_t kSide = DepthImage::kSide;
// Frequencies of the spectrum are multiples of half a wave per image, twice as fine as an FFT's, so that no peak falls
// between.
constexpr std::uint32_t kSteps = 2 * kSide;      ///< of a whole turn
constexpr std::uint32_t kRight = kSide / 2 + 1;  ///< horizontal frequencies: from 0 to a wave of four cells
constexpr std::uint32_t kUp = 2 * kRight - 1;    ///< vertical frequencies: the same range, both signs
constexpr std::uint32_t kRow = (kRight + kLanes - 1) / kLanes * kLanes;  ///< numbers of a row of horizontal frequencies
/// Power of a wave over the mean of noise. Noise exceeds it at one frequency with probability exp(-14), 8e-7; an image
/// has 2145 frequencies.
constexpr float kMinPower = 14;
constexpr std::uint32_t kLowest = 2;  ///< half waves per image; anything lower may be the view's motion
constexpr double kMinDistance = 3;    ///< half waves per image: closer peaks belong to one wave
constexpr int kSearchSteps = 3;       ///< Gauss-Newton steps of a new wave; every later round adds one
constexpr double kRidge = 1e-3;       ///< share of the trace added to the diagonal of the normal equations
/// Largest change of the phase at the image's side in one step, turns. Beyond that the linearization does not hold.
constexpr double kMaxTurned = 0.5;

/// exp(2 pi i k / kSteps)
Phasor turn(std::uint32_t k) { return phasor(static_cast<float>(k % kSteps) / kSteps); }

/// Adds a row of phasors, real parts then imaginary parts, times a number.
PLUMBLINE_WIDE void add_row(float* sums, const float* row, float number) {
  for (std::size_t j = 0; j < 2 * kRow; j += kLanes) {
    Lanes sum, part;
    load(sum, sums + j);
    load(part, row + j);
    store(sums + j, sum + number * part);
  }
}

/// Adds the same times the conjugate of a phasor.
PLUMBLINE_WIDE void add_turned_row(float* sums, const float* row, float re, float im) {
  for (std::size_t j = 0; j < kRow; j += kLanes) {
    Lanes sum_re, sum_im, row_re, row_im;
    load(sum_re, sums + j);
    load(sum_im, sums + kRow + j);
    load(row_re, row + j);
    load(row_im, row + kRow + j);
    store(sums + j, sum_re + (row_re * re + row_im * im));
    store(sums + kRow + j, sum_im + (row_im * re - row_re * im));
  }
}

}  // namespace

DepthFrame::DepthFrame(const Vec3d& centre, const Vec3d& ray, double half_side_mm)
    : middle(centre), axis(ray), half_side(half_side_mm) {
  const Frame frame(axis.cast<float>());
  right = frame.t.cast<double>();
  up = frame.s.cast<double>();
}

void DepthImage::add(const Vec3d& x, double offset, double weight) {
  const Vec3d d = x - frame_.middle;
  const double scale = 0.5 * kSide / frame_.half_side;
  const double u = d.dot(frame_.right) * scale + 0.5 * kSide;
  const double v = d.dot(frame_.up) * scale + 0.5 * kSide;
  if (!(u >= 0 && u < kSide && v >= 0 && v < kSide)) return;
  Cell& cell = cells_[static_cast<std::uint32_t>(v) * kSide + static_cast<std::uint32_t>(u)];
  cell.weight += static_cast<float>(weight);
  cell.offset += static_cast<float>(offset);
  cell.depth += static_cast<float>(weight * d.dot(frame_.axis));
}

/// Vector from the middle of the view's points to the middle of a cell's, mm. The cell must have points.
Vec3d DepthImage::place(std::uint32_t cell) const {
  const double size = 2 * frame_.half_side / kSide;
  const std::uint32_t row = cell / kSide;
  const double right = (cell % kSide + 0.5) * size - frame_.half_side;
  const double up = (row + 0.5) * size - frame_.half_side;
  return frame_.right * right + frame_.up * up +
         frame_.axis * static_cast<double>(cells_[cell].depth / cells_[cell].weight);
}

void DepthImage::fit(Wave& wave, bool fit_frequency) {
  using Vec5d = Eigen::Matrix<double, 5, 1>;
  using Mat5d = Eigen::Matrix<double, 5, 5>;
  Mat5d products = Mat5d::Zero();
  Vec5d right = Vec5d::Zero();
  Vec5d terms = Vec5d::Zero();
  for (std::uint32_t i = 0; i < kCells; ++i) {
    if (!(cells_[i].weight > 0)) continue;
    const Vec3d x = place(i);
    const Phasor p = wave.at(x);
    terms[0] = static_cast<double>(p.re);
    terms[1] = static_cast<double>(p.im);
    if (fit_frequency) terms.tail<3>() = (wave.im * terms[0] - wave.re * terms[1]) * (2 * std::numbers::pi) * x;
    right += static_cast<double>(cells_[i].offset) * terms;
    const Vec5d weighted = static_cast<double>(cells_[i].weight) * terms;
    for (Eigen::Index row = 0; row < (fit_frequency ? 5 : 2); ++row) {  // the lower half is enough
      for (Eigen::Index column = 0; column <= row; ++column) products(row, column) += weighted[row] * terms[column];
    }
  }
  const double of_amplitude = products.topLeftCorner<2, 2>().trace();
  const double of_frequency = products.bottomRightCorner<3, 3>().trace();
  if (!(of_amplitude > 0)) return;
  products.diagonal().head<2>().array() += kRidge * of_amplitude;
  products.diagonal().tail<3>().array() += of_frequency > 0 ? kRidge * of_frequency : 1;
  Vec5d step = products.ldlt().solve(right);
  const double turned = step.tail<3>().norm() * frame_.half_side;
  if (turned > kMaxTurned) step.tail<3>() *= kMaxTurned / turned;
  const Wave before = wave;
  wave.re += step[0];
  wave.im += step[1];
  wave.frequency += step.tail<3>();
  for (std::uint32_t i = 0; i < kCells; ++i) {
    if (!(cells_[i].weight > 0)) continue;
    const Vec3d x = place(i);
    cells_[i].offset -= cells_[i].weight * static_cast<float>(wave.depth(x) - before.depth(x));
  }
}

std::size_t WaveSearch::bytes() {
  return 2 * Arena::rounded(std::size_t{kSide} * 2 * kRow * sizeof(float)) +
         2 * Arena::rounded(std::size_t{kUp} * kRight * sizeof(float));
}

Expected<WaveSearch> WaveSearch::create(Arena& arena) {
  WaveSearch search;
  PLUMBLINE_TRY(arena.take_top(search.rows_, std::size_t{kSide} * 2 * kRow, kStage));
  PLUMBLINE_TRY(arena.take_top(search.powers_, std::size_t{kUp} * kRight, kStage));
  PLUMBLINE_TRY(arena.take_top(search.sorted_, search.powers_.size(), kStage));
  PLUMBLINE_TRY(arena.take_top(search.turns_, search.rows_.size(), kStage));
  std::fill(search.turns_.begin(), search.turns_.end(), 0.0F);
  for (std::uint32_t x = 0; x < kSide; ++x) {
    for (std::uint32_t j = 0; j < kRight; ++j) {
      const Phasor w = turn(j * x);
      search.turns_[x * 2 * kRow + j] = w.re;
      search.turns_[x * 2 * kRow + kRow + j] = -w.im;
    }
  }
  return search;
}

/// Computes the power spectrum of the image: first along the rows, then across them.
void WaveSearch::transform(std::span<const DepthImage::Cell> cells) {
  std::fill(rows_.begin(), rows_.end(), 0.0F);
  for (std::uint32_t y = 0; y < kSide; ++y) {
    for (std::uint32_t x = 0; x < kSide; ++x) {
      const float offset = cells[y * kSide + x].offset;
      if (offset != 0) add_row(&rows_[y * 2 * kRow], &turns_[x * 2 * kRow], offset);
    }
  }
  for (std::uint32_t l = 0; l < kUp; ++l) {
    std::array<float, std::size_t{2}* kRow> sums = {};
    for (std::uint32_t y = 0; y < kSide; ++y) {
      const Phasor w = turn((l + kSteps - (kRight - 1)) * y);
      add_turned_row(sums.data(), &rows_[y * 2 * kRow], w.re, w.im);
    }
    for (std::uint32_t j = 0; j < kRight; ++j)
      powers_[l * kRight + j] = sums[j] * sums[j] + sums[kRow + j] * sums[kRow + j];
  }
}

/// Finds the frequency of the strongest wave that stands out and is not known yet.
bool WaveSearch::find_strongest(const Ripple& ripple, const DepthFrame& frame, Wave& wave) {
  const double step = 1 / (4 * frame.half_side);  // half a wave per image
  std::copy(powers_.begin(), powers_.end(), sorted_.begin());
  // Powers of noise are distributed exponentially: their mean is the median over ln 2.
  float most = kMinPower * median(sorted_) / std::numbers::ln2_v<float>;
  bool found = false;
  for (std::uint32_t l = 0; l < kUp; ++l) {
    const int up = static_cast<int>(l) - static_cast<int>(kRight - 1);
    for (std::uint32_t right = 0; right < kRight; ++right) {
      if (static_cast<std::uint32_t>(up * up) + right * right < kLowest * kLowest) continue;
      if (!(powers_[l * kRight + right] > most)) continue;
      const Vec3d frequency = (frame.right * right + frame.up * up) * step;
      const auto is_same = [&](const Wave& other) {
        const Vec3d across = other.frequency - frame.axis * frame.axis.dot(other.frequency);
        return std::min((frequency - across).norm(), (frequency + across).norm()) < kMinDistance * step;
      };
      if (std::any_of(ripple.wave.begin(), ripple.wave.begin() + ripple.waves, is_same)) continue;
      most = powers_[l * kRight + right];
      wave.frequency = frequency;
      found = true;
    }
  }
  return found;
}

void WaveSearch::improve(Ripple& ripple, DepthImage& image) {
  ripple.middle = image.frame().middle;
  for (std::uint32_t k = 0; k < ripple.waves; ++k) image.fit(ripple.wave[k], true);
  while (ripple.waves < Ripple::kMaxWaves) {
    transform(image.cells());
    Wave wave;
    if (!find_strongest(ripple, image.frame(), wave)) break;
    image.fit(wave, false);
    for (int k = 0; k < kSearchSteps; ++k) image.fit(wave, true);
    ripple.wave[ripple.waves++] = wave;
  }
  ripple.pack();
}

}  // namespace plumbline
