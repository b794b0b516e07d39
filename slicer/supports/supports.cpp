#include "slicer/supports/supports.hpp"

#include <algorithm>

namespace plumbline {

SupportShape::SupportShape(const SupportSettings& settings, const PrintGrid& grid)
    : pitch_(grid),
      layer_height_(nanometres(static_cast<double>(grid.layer_height_mm))),
      head_(nanometres(settings.head_front_diameter / 2)),
      pillar_(nanometres(settings.pillar_diameter / 2)),
      base_(nanometres(settings.base_diameter / 2)),
      head_width_(nanometres(settings.head_width)),
      base_height_(nanometres(settings.base_height)),
      penetration_(
          static_cast<std::uint32_t>((nanometres(settings.head_penetration) + layer_height_ / 2) / layer_height_)) {}

Nanometres SupportShape::radius(const Support& support, std::uint32_t layer) const {
  if (layer >= support.tip) return head_;
  const Nanometres middle = (2 * Nanometres{layer} + 1) * layer_height_ / 2;
  const Nanometres tip = support.tip * layer_height_;
  Nanometres radius = std::min(pillar_, cone(tip - middle));
  if (!support.on_plate()) return std::min(radius, cone(middle - support.first * layer_height_));
  const Nanometres height = std::min(base_height_, tip / 3);
  if (middle < height) radius = std::max(radius, base_ - (base_ - pillar_) * middle / height);
  return radius;
}

}  // namespace plumbline
