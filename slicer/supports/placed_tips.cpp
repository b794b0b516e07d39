#include "slicer/supports/placed_tips.hpp"

#include <algorithm>
#include <cmath>

namespace plumbline::inline slicer {
namespace {

constexpr Nanometres kBeside = 500'000;

}  // namespace

void PlacedTips::look_at(std::uint32_t layer, ConstBitImage mask, ConstBitImage below) {
  const double height = layer * static_cast<double>(grid_.layer_height_mm);
  for (std::size_t i = 0; i < surfaces().size(); ++i) {
    const SupportPlace& place = settings_->added.list[i];
    Surface& best = surfaces_[i];
    const double x = place.x / static_cast<double>(grid_.pitch_x_mm);
    const double y = place.y / static_cast<double>(grid_.pitch_y_mm);
    if (!(x >= 0 && x < grid_.columns && y >= 0 && y < grid_.rows && std::abs(height - place.z) <= kPlaceReach)) {
      continue;
    }
    const auto look = [&](std::uint32_t row, std::uint32_t begin, std::uint32_t end) {
      for (std::uint32_t column = begin; column < end; ++column) {
        if (!mask.at(column, row) || below.at(column, row)) continue;
        const Nanometres dx = (Nanometres{column} - static_cast<Nanometres>(x)) * pitch_.x;
        const Nanometres dy = (Nanometres{row} - static_cast<Nanometres>(y)) * pitch_.y;
        if (dx * dx + dy * dy < best.away) best = {dx * dx + dy * dy, column, row, layer};
      }
    };
    for_each_disc_span(pitch_, static_cast<std::uint32_t>(x), static_cast<std::uint32_t>(y), kBeside, grid_.columns,
                       grid_.rows, look);
  }
}

std::uint32_t PlacedTips::missed() const {
  std::uint32_t missed = 0;
  for (std::size_t i = 0; i < surfaces().size(); ++i) missed |= (surfaces_[i].layer == 0 ? 1U : 0U) << i;
  return missed;
}

bool PlacedTips::is_blocked(std::uint32_t column, std::uint32_t row, std::uint32_t layer) const {
  return std::ranges::any_of(settings_->blocked.all(), [&](const SupportPlace& ball) {
    const double x = (column + 0.5) * static_cast<double>(grid_.pitch_x_mm) - ball.x;
    const double y = (row + 0.5) * static_cast<double>(grid_.pitch_y_mm) - ball.y;
    const double z = layer * static_cast<double>(grid_.layer_height_mm) - ball.z;
    return x * x + y * y + z * z <= ball.radius * ball.radius;
  });
}

}  // namespace plumbline::inline slicer
