#pragma once
/// How the light of a layer is divided among masks that are shown one after another, while the plate stands still. Doses of one height add
/// up, so a pixel that only some of the masks show gets their share of the layer's dose:
///
///   grey on a panel that shows black and white   with n exposures for grey, the layer's time T in T/2, T/4, ... T/2^n and the last T/2^n.
///                                                White is in all of them, a pixel of k/2^n in those that are the bits of k
///   elephant's foot                              a normal layer's time for the whole mask, what a bottom layer gets beyond that for the
///                                                mask without its outline: an outline has no more light than those above it, and the
///                                                rest still holds on to the plate
///   exposure test                                the shortest exposure for the whole mask, what the second strip gets beyond that for the
///                                                mask from there on, and so forth
///
/// Masks that would be the same are one exposure. A layer without grey or foot is one, as long as it always was.

#include <algorithm>
#include <array>
#include <chrono>
#include <cstdint>
#include <span>

#include "firmware/print/job/print_plan.hpp"

namespace plumbline::firmware {

/// What of a layer's mask takes exposures of its own.
struct MaskNeeds {
  std::uint32_t shares = 0;  ///< bit k, 0 < k < 2^n: it has pixels with k/2^n of the light
  bool foot = false;         ///< its outline is to have less light than the rest
  std::uint32_t strips = 0;  ///< bit c: it has pixels in strip c of PrintPlan::test
};

/// An exposure of a layer.
struct LayerExposure {
  std::uint32_t shares = 0;  ///< bit k: shows pixels that get k/2^n of the light
  bool inside = false;       ///< shows the mask without its outline, and no grey
  std::uint32_t from = 0;    ///< shows the mask's columns from here on
  nanoseconds time{};        ///< above 0
};

/// The exposures of a layer, in order. Those of the whole mask come first, the shortest before the others: the next layer's mask takes longest to
/// make, so it is made during the longest exposure.
class LayerExposures {
 public:
  static constexpr std::uint32_t kMost = std::max(GreyScale::kMostExposures + 2, ExposureTest::kMostStrips);

  std::span<const LayerExposure> all() const { return std::span(list_).first(count_); }
  std::uint32_t count() const { return count_; }
  /// The one that a layer needs when it has had `lit` of its light; the last one if it has had all.
  std::uint32_t at(nanoseconds lit) const;
  /// Light that the layer has had when exposure `i` begins.
  nanoseconds begin(std::uint32_t i) const;

  void add(const LayerExposure& exposure) { list_[count_++] = exposure; }
  void lengthen_last(nanoseconds more) { list_[count_ - 1].time += more; }

 private:
  std::array<LayerExposure, kMost> list_{};
  std::uint32_t count_ = 0;
};

/// n of a layer: the plan's, or less so that none is shorter than plan.least_exposure.
std::uint32_t grey_exposures_of(const PrintPlan& plan, std::uint32_t layer);

/// k of a level's share of the light, rounded to k/2^n.
/// @param level  0 to 255
constexpr std::uint32_t share_of(std::uint32_t level, std::uint32_t n) { return ((level << (n + 1)) + 255) / 510; }

/// One exposure or more, whose times add up to exposure_of(); to less if the last strips of a test have no pixels.
LayerExposures exposures_of(const PrintPlan& plan, std::uint32_t layer, MaskNeeds needs);

/// The most that any mask of this layer could need.
LayerExposures most_exposures_of(const PrintPlan& plan, std::uint32_t layer);

/// Room for the exposures of all layers.
std::size_t most_exposures(const PrintPlan& plan);

}  // namespace plumbline::firmware
