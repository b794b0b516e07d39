#include "firmware/print/job/layer_exposures.hpp"

#include <algorithm>
#include <utility>

namespace plumbline::firmware {
namespace {

/// The journal keeps whole microseconds of light, so exposures change at those.
nanoseconds whole_us(nanoseconds time) { return std::chrono::floor<std::chrono::microseconds>(time); }

/// What a bottom or faded layer gets beyond a normal one; 0 if that is too short for an exposure.
nanoseconds beyond_normal(const PrintPlan& plan, std::uint32_t layer) {
  const nanoseconds more = exposure_of(plan, layer) - normal_exposure_of(plan, layer);
  return more >= plan.least_exposure && more > nanoseconds::zero() ? whole_us(more) : nanoseconds();
}

/// Which of the shares have bit `b`.
std::uint32_t shares_with_bit(std::uint32_t shares, std::uint32_t b) {
  std::uint32_t with = 0;
  for (std::uint32_t k = 1; k < 32; ++k) with |= (k >> b & 1U) << k;
  return shares & with;
}

/// Divides `whole` by the bits of the shares. Bits that the same shares have are one exposure.
void add_greys(std::uint32_t shares, std::uint32_t n, nanoseconds whole, LayerExposures& exposures) {
  struct Group {
    std::uint32_t shares = 0, weight = 0;  ///< of 2^n
  };
  std::array<Group, GreyScale::kMostExposures + 1> groups = {Group{.weight = 1}};  // white alone: the last T/2^n
  std::size_t count = 1;
  for (std::uint32_t b = 0; b < n; ++b) {
    const std::uint32_t its = shares_with_bit(shares, b);
    const auto found =
        std::find_if(groups.begin(), groups.begin() + count, [its](const Group& group) { return group.shares == its; });
    if (found == groups.begin() + count) groups[count++] = {.shares = its};
    found->weight += 1U << b;
  }
  const auto used = std::span(groups).first(count);
  for (std::size_t i = 1; i < count; ++i) {
    for (std::size_t j = i; j > 0 && used[j].weight < used[j - 1].weight; --j) std::swap(used[j], used[j - 1]);
  }
  nanoseconds left = whole;
  for (const Group& group : used.first(count - 1)) {
    const nanoseconds time = whole_us(whole * group.weight / (1U << n));
    exposures.add({.shares = group.shares, .time = time});
    left -= time;
  }
  exposures.add({.shares = used.back().shares, .time = left});
}

void add_strips(const TestStrips& test, std::uint32_t strips, LayerExposures& exposures) {
  exposures.add({.time = test.exposures[0]});
  for (std::uint32_t c = 1; c < test.count && strips >> c != 0; ++c) {
    const nanoseconds more = test.exposures[c] - test.exposures[c - 1];
    if ((strips >> (c - 1) & 1U) != 0) {
      exposures.add({.from = test.column(c), .time = more});
    } else {
      exposures.lengthen_last(more);
    }
  }
}

}  // namespace

std::uint32_t LayerExposures::at(nanoseconds lit) const {
  std::uint32_t i = 0;
  for (nanoseconds end{}; i + 1 < count_; ++i) {
    end += list_[i].time;
    if (lit < end) break;
  }
  return i;
}

nanoseconds LayerExposures::begin(std::uint32_t i) const {
  nanoseconds begin{};
  for (const LayerExposure& exposure : all().first(i)) begin += exposure.time;
  return begin;
}

std::uint32_t grey_exposures_of(const PrintPlan& plan, std::uint32_t layer) {
  const nanoseconds time = std::min(exposure_of(plan, layer), normal_exposure_of(plan, layer));
  std::uint32_t n = plan.grey_exposures;
  while (n > 0 && time / (1U << n) < plan.least_exposure) --n;
  return n;
}

LayerExposures exposures_of(const PrintPlan& plan, std::uint32_t layer, MaskNeeds needs) {
  LayerExposures exposures;
  if (is_tested(plan, layer)) {
    add_strips(plan.test, needs.strips, exposures);
    return exposures;
  }
  const nanoseconds inside = needs.foot ? beyond_normal(plan, layer) : nanoseconds();
  add_greys(needs.shares, grey_exposures_of(plan, layer), exposure_of(plan, layer) - inside, exposures);
  if (inside > nanoseconds::zero()) exposures.add({.inside = true, .time = inside});
  return exposures;
}

LayerExposures most_exposures_of(const PrintPlan& plan, std::uint32_t layer) {
  const std::uint32_t all = (1U << (1U << grey_exposures_of(plan, layer))) - 1;
  return exposures_of(
      plan, layer,
      {.shares = all & ~1U, .foot = plan.elephant_foot > Distance(), .strips = (1U << plan.test.count) - 1});
}

std::size_t most_exposures(const PrintPlan& plan) {
  std::size_t count = 0;
  for (std::uint32_t layer = 0; layer < plan.layers; ++layer) count += most_exposures_of(plan, layer).count();
  return count;
}

}  // namespace plumbline::firmware
