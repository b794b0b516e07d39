#pragma once
/// Heights of a print's layers, in layers of its R-Rep.

#include <algorithm>
#include <array>
#include <cassert>
#include <cstdint>
#include <span>

namespace plumbline::inline slicer {

/// A layer of the print: `step` layers of the R-Rep, from `first` on.
struct LayerStep {
  std::uint32_t first = 0, step = 1;

  std::uint32_t end() const { return first + step; }
  /// The R-Rep's layer whose mask is printed: the one in the middle.
  std::uint32_t sampled() const { return first + step / 2; }
};

/// How many layers of the R-Rep each layer of the print is high. Usually one. In an adaptive print the R-Rep has the finest layers, and those of
/// the print are runs of equal height, each an odd number of these, so that a mask is sampled in the middle of its layer. Holds no pointer.
class LayerSteps {
 public:
  static constexpr std::uint32_t kMostStep = 15;
  static constexpr std::uint32_t kMostRuns = 128;
  struct Run {
    std::uint16_t layers_end = 0;  ///< of the print, after the run
    std::uint16_t rrep_end = 0;    ///< of the R-Rep, after the run
    std::uint16_t step = 1;
  };

  /// Each layer is one of the R-Rep.
  LayerSteps() = default;

  bool all_one() const { return count_ == 0; }
  std::span<const Run> runs() const { return std::span(runs_).first(count_); }

  /// Adds a layer on top, if there is room for it: its run, and 65,535 layers of the R-Rep.
  /// @param step  odd, 1 to kMostStep
  bool add(std::uint32_t step) {
    assert(step % 2 == 1 && step <= kMostStep);
    const Run last = count_ > 0 ? runs_[count_ - 1] : Run{};
    if (last.rrep_end + step > UINT16_MAX) return false;
    if (count_ == 0 || last.step != step) {
      if (count_ == kMostRuns) return false;
      runs_[count_++] = {last.layers_end, last.rrep_end, static_cast<std::uint16_t>(step)};
    }
    Run& run = runs_[count_ - 1];
    ++run.layers_end;
    run.rrep_end = static_cast<std::uint16_t>(run.rrep_end + step);
    return true;
  }
  /// Whether runs are as add() makes them. Of steps that come from elsewhere.
  bool valid() const {
    if (count_ > kMostRuns) return false;
    Run before;
    for (const Run& run : runs()) {
      const bool odd = run.step % 2 == 1 && run.step <= kMostStep;
      if (!odd || run.layers_end <= before.layers_end) return false;
      if (run.rrep_end != before.rrep_end + (run.layers_end - before.layers_end) * run.step) return false;
      before = run;
    }
    return true;
  }

  /// @param layer  of the print; above all runs, layers are one of the R-Rep
  LayerStep of(std::uint32_t layer) const {
    if (all_one()) return {layer, 1};
    const auto all = runs();
    const auto run = std::ranges::find_if(all, [&](const Run& r) { return layer < r.layers_end; });
    if (run == all.end()) return {all.back().rrep_end + (layer - all.back().layers_end), 1};
    return {run->rrep_end - (run->layers_end - layer) * std::uint32_t{run->step}, run->step};
  }
  /// The layer of the print that has a layer of the R-Rep.
  std::uint32_t layer_at(std::uint32_t rrep_layer) const {
    if (all_one()) return rrep_layer;
    const auto all = runs();
    const auto run = std::ranges::find_if(all, [&](const Run& r) { return rrep_layer < r.rrep_end; });
    if (run == all.end()) return all.back().layers_end + (rrep_layer - all.back().rrep_end);
    return run->layers_end - (run->rrep_end - rrep_layer + run->step - 1U) / run->step;
  }
  /// Layers of a print whose R-Rep has so many: the last is sampled below its top.
  /// @param rrep_layers  1 or more
  std::uint32_t layers(std::uint32_t rrep_layers) const {
    const std::uint32_t last = layer_at(rrep_layers - 1);
    return of(last).sampled() < rrep_layers ? last + 1 : last;
  }
  /// The first layer of the print after `layer` that may be of another height.
  std::uint32_t run_end(std::uint32_t layer) const {
    for (const Run& run : runs()) {
      if (layer < run.layers_end) return run.layers_end;
    }
    return UINT32_MAX;
  }

 private:
  std::array<Run, kMostRuns> runs_ = {};
  std::uint32_t count_ = 0;
};

}  // namespace plumbline::inline slicer
