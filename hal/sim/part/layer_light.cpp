#include "hal/sim/part/layer_light.hpp"

#include <algorithm>
#include <bit>
#include <cmath>

#include "slicer/core/bit_spans.hpp"

namespace plumbline::inline hal::inline sim {

bool LayerLight::add(ConstBitImage mask, std::span<const GreyRun> greys, Dose dose) {
  for (Light& light : std::span(lights_).first(count_)) {
    if (!std::ranges::equal(light.bits, mask.words()) || !std::ranges::equal(light.greys, greys)) continue;
    light.dose = light.dose + dose;
    return false;
  }
  if (count_ == lights_.size()) lights_.emplace_back();
  Light& light = lights_[count_++];
  light.dose = dose;
  light.bits.assign(mask.words().begin(), mask.words().end());
  light.greys.assign(greys.begin(), greys.end());
  return true;
}

void LayerLight::combine(BitImage bits, std::vector<GreyRun>& greys) const {
  greys.clear();
  if (count_ == 1) {
    std::ranges::copy(lights_[0].bits, bits.words().begin());
    greys.assign(lights_[0].greys.begin(), lights_[0].greys.end());
    return;
  }
  bits.clear();
  double dose = 0;
  for (const Light& light : lights()) dose += light.dose.value();
  for (std::uint32_t row = 0; row < rows_; ++row) combine_row(row, dose, bits, greys);
}

void LayerLight::combine_row(std::uint32_t row, double dose, BitImage bits, std::vector<GreyRun>& greys) const {
  const std::size_t stride = bits.stride(), first = row * stride;
  const auto out = bits.row(row);
  std::vector<std::uint64_t> differs(stride);  // pixels that some of the masks give light to and others not, or less
  for (std::size_t w = 0; w < stride; ++w) {
    std::uint64_t all = ~std::uint64_t{0};
    for (const Light& light : lights()) {
      all &= light.bits[first + w];
      out[w] |= light.bits[first + w];
    }
    differs[w] = all ^ out[w];
  }
  const auto of_row = [this, row](const Light& light) {
    const auto begin =
        std::ranges::lower_bound(light.greys, row * columns_, {}, [](const GreyRun& run) { return run.pixel; });
    const auto end =
        std::ranges::lower_bound(light.greys, (row + 1) * columns_, {}, [](const GreyRun& run) { return run.pixel; });
    return std::span(begin, end);
  };
  for (const Light& light : lights()) {
    for (const GreyRun& run : of_row(light)) {
      const std::uint32_t begin = run.pixel % columns_;
      for_each_word(begin, begin + run.count, [&](std::uint32_t w, std::uint64_t its) { differs[w] |= its; });
    }
  }
  if (std::ranges::all_of(differs, [](std::uint64_t word) { return word == 0; })) return;
  std::vector<double> sums(columns_);  // of level times dose
  for (const Light& light : lights()) {
    const auto is_lit = [&](std::uint32_t column) {
      return (light.bits[first + column / 64] >> column % 64 & 1U) != 0;
    };
    for (std::uint32_t column = 0; column < columns_; ++column) {
      if (is_lit(column)) sums[column] += light.dose.value() * kFullLevel;
    }
    for (const GreyRun& run : of_row(light)) {
      for (std::uint32_t i = 0, column = run.pixel % columns_; i < run.count; ++i, ++column) {
        sums[column] += light.dose.value() * (run.level - (is_lit(column) ? kFullLevel : 0));
      }
    }
  }
  for (std::size_t w = 0; w < stride; ++w) {
    for (std::uint64_t rest = differs[w]; rest != 0; rest &= rest - 1) {
      const auto column = static_cast<std::uint32_t>(64 * w) + static_cast<std::uint32_t>(std::countr_zero(rest));
      const auto level = static_cast<std::uint8_t>(std::lround(sums[column] / dose));
      const std::uint32_t pixel = row * columns_ + column;
      if (!is_grey(level)) {
        fill(bits, row, column, column + 1, level == kFullLevel);
      } else if (!greys.empty() && greys.back().level == level && greys.back().end() == pixel && column > 0) {
        ++greys.back().count;
      } else {
        greys.push_back({pixel, 1, level});
      }
    }
  }
}

}  // namespace plumbline::inline hal::inline sim
