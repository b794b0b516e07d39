#include "slicer/reader/formats/splats/splat_filter.hpp"

#include <algorithm>

#include "slicer/reader/records/scan_pose.hpp"

namespace plumbline::inline slicer {

void SplatFilter::survey(double opacity, double longest) {
  if (!(opacity >= kFaintest) || !std::isfinite(longest)) return;
  const double place = std::clamp((longest - kLow) / kStep, 0.0, static_cast<double>(kClasses - 1));
  ++count_[static_cast<std::size_t>(place)];
}

void SplatFilter::end_survey() {
  surveying_ = false;
  std::uint64_t all = 0;
  for (const std::uint64_t count : count_) all += count;
  std::uint64_t below = 0;
  std::size_t median = 0;
  while (median + 1 < kClasses && 2 * (below + count_[median]) < all) below += count_[median++];
  most_ = kLow + kStep * static_cast<double>(median + 1) + kLargest;
}

PointFilter::Verdict SplatFilter::look(SlotValues& row) {
  double* const scale = row + kScale;
  if (!has_third_) scale[2] = std::min(scale[0], scale[1]) - 2 * kFlat;
  const auto [low, high] = std::minmax_element(scale, scale + 3);
  const bool finite = std::isfinite(scale[0]) && std::isfinite(scale[1]) && std::isfinite(scale[2]);
  if (surveying_) {
    if (finite) survey(row[kOpacity], *high);
    return Verdict::kIgnore;
  }
  if (!finite || !(row[kOpacity] >= kFaintest) || *high > most_) return Verdict::kLeaveOut;
  std::fill_n(row + kNx, 3, 0.0);
  const auto shortest = low - scale;
  const double middle = std::min(scale[(shortest + 1) % 3], scale[(shortest + 2) % 3]);
  if (middle - *low < kFlat) return Verdict::kKeep;
  const double* const turn = row + kTurn;
  const auto rotation = rotation_of(turn[0], turn[1], turn[2], turn[3]);
  if (rotation) {
    for (int a = 0; a < 3; ++a) row[kNx + a] = (*rotation)(a, shortest);
  }
  return Verdict::kKeep;
}

}  // namespace plumbline::inline slicer
