#include "firmware/machine/part_figures.hpp"

#include <algorithm>
#include <cmath>
#include <utility>

namespace plumbline::firmware {
namespace {

/// Sums of a kind of points, um.
struct Kind {
  double count = 0, sum = 0, squares = 0;

  void add(double um) {
    ++count;
    sum += um;
    squares += um * um;
  }
  double mean() const { return count > 0 ? sum / count : DeviationFigures::kNone; }
  double rms() const { return count > 0 ? std::sqrt(squares / count) : DeviationFigures::kNone; }
  double spread() const { return count > 0 ? std::sqrt(std::max(0.0, squares / count - mean() * mean())) : rms(); }
};

}  // namespace

DeviationFigures deviation_figures(std::string against, std::span<const OrientedPoint> truth,
                                   std::span<const float> deviations_mm) {
  constexpr float kCos30 = 0.8660254F, kCos60 = 0.5F;
  DeviationFigures figures{.against = std::move(against), .points = truth.size()};
  Kind all, down, wall, top;
  for (std::size_t i = 0; i < truth.size(); ++i) {
    const double um = 1000 * static_cast<double>(deviations_mm[i]);
    if (!std::isfinite(um)) {
      ++figures.missing;
      figures.sealed += um > 0 ? 1 : 0;
      continue;
    }
    const float up = truth[i].normal[2];
    all.add(um);
    if (up <= -kCos60) down.add(um);
    if (std::abs(up) < kCos60) wall.add(um);
    if (up >= kCos30) top.add(um);
  }
  figures.rms = all.rms();
  figures.down_mean = down.mean();
  figures.down_rms = down.spread();
  figures.wall_mean = wall.mean();
  figures.wall_rms = wall.spread();
  figures.top_rms = top.rms();
  return figures;
}

}  // namespace plumbline::firmware
