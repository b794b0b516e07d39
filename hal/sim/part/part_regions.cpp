#include "hal/sim/part/part_regions.hpp"

#include "slicer/core/arena.hpp"

namespace plumbline::inline hal::inline sim {

void PartRegions::find(ConstBitImage image) {
  LayerRegions::Settings settings{.runs_per_row = 8, .join_white_corners = false, .stage = "simulated part"};
  while (regions_.rows() != image.rows() || !regions_.label(image)) {
    while (LayerRegions::bytes_needed(image.rows(), settings) <= memory_.size()) settings.runs_per_row *= 2;
    memory_ = std::vector<std::byte>(LayerRegions::bytes_needed(image.rows(), settings) + Arena::kAlignment);
    Arena arena(memory_);
    regions_ = LayerRegions::create(image.columns(), image.rows(), arena, settings).value();
  }
  number_.assign(regions_.run_count(), 0);
  white_.clear();
  black_.assign(1, LayerRegions::kOutside);
  const auto begin = [&](std::uint32_t name, bool white) {
    number_[name] = static_cast<std::uint32_t>(white ? white_.size() : black_.size());
    white ? white_.push_back({.region = name}) : black_.push_back(name);
    return true;
  };
  static_cast<void>(measure_regions(
      regions_, begin, [&](std::uint32_t name) -> auto& { return white_[number_[name]]; }));
}

}  // namespace plumbline::inline hal::inline sim
