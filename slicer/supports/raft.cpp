#include "slicer/supports/raft.hpp"

#include <algorithm>
#include <cmath>

#include "slicer/core/numbers/degrees.hpp"

namespace plumbline::inline slicer {
namespace {

constexpr double kFar = 1e300;
constexpr double kJoined = -1;
/// Least half width of a bar on the plate, mm: narrower ones would not stick.
constexpr double kLeastHalf = 0.4;

}  // namespace

Status add_raft(const SupportSettings& settings, StrutList& list, std::span<double> nearest,
                std::span<std::uint32_t> to) {
  const SineCosine slope = sine_cosine(settings.pad_wall_slope);
  const double leaning = settings.pad_wall_thickness * slope.cosine / slope.sine;
  const auto px = static_cast<double>(list.grid().pitch_x_mm);
  const auto py = static_cast<double>(list.grid().pitch_y_mm);
  const double wide = (list.grid().columns - 1) * px;
  const double deep = (list.grid().rows - 1) * py;
  const std::uint32_t end =
      list.layer_at(settings.pad_wall_thickness + static_cast<double>(list.grid().layer_height_mm) / 2);
  const auto add = [&](const Place& a, const Place& b, double half) {
    // Never cut at the panel's edge.
    for (const Place& p : {a, b}) half = std::min({half, p.x, p.y, wide - p.x, deep - p.y});
    half = std::max(half, kLeastHalf);
    return list.add(StrutKind::kRaft, a, b, 0, end, std::max(kLeastHalf, half - leaning), half, true);
  };
  const auto pillars = list.pillars();
  const auto place = [&](std::size_t i) { return Place{pillars[i].x, pillars[i].y, 0}; };
  for (std::size_t i = 0; i < pillars.size(); ++i) {
    if (!pillars[i].on_plate) continue;
    PLUMBLINE_TRY(add(place(i), place(i), settings.base_diameter / 2 + settings.pad_brim_size));
  }
  // Bars are as wide as the brim on both sides, and wide enough for the bevel.
  const double bar = std::max(settings.pad_brim_size, leaning + kLeastHalf);
  for (std::size_t i = 0; i < pillars.size(); ++i) nearest[i] = pillars[i].on_plate ? kFar : kJoined;
  std::size_t next = 0;
  while (next < pillars.size() && nearest[next] == kJoined) ++next;
  while (next < pillars.size()) {
    if (nearest[next] < kFar) {
      if (nearest[next] <= settings.pad_max_merge_distance * settings.pad_max_merge_distance) {
        PLUMBLINE_TRY(add(place(next), place(to[next]), bar));
      }
    }
    nearest[next] = kJoined;
    const std::size_t joined = next;
    next = pillars.size();
    for (std::size_t i = 0; i < pillars.size(); ++i) {
      if (nearest[i] == kJoined) continue;
      const double dx = pillars[i].x - pillars[joined].x;
      const double dy = pillars[i].y - pillars[joined].y;
      if (dx * dx + dy * dy < nearest[i]) {
        nearest[i] = dx * dx + dy * dy;
        to[i] = static_cast<std::uint32_t>(joined);
      }
      if (next == pillars.size() || nearest[i] < nearest[next]) next = i;
    }
  }
  return {};
}

}  // namespace plumbline::inline slicer
