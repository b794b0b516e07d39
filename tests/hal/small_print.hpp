#pragma once
/// The simplest print of a few layers with the HAL alone: no checks, no pauses, and the first error ends it.

#include <cstdint>
#include <functional>

#include "hal/await.hpp"
#include "hal/machine.hpp"

namespace plumbline {

struct SmallPrint {
  std::uint32_t layers = 5;
  Distance layer_height = 50_um;
  nanoseconds cure = std::chrono::milliseconds(2500);
  Distance lift = 5_mm;
  Speed speed = Speed(4);
  std::function<void(std::uint32_t, BitImage)> draw =
      nullptr;  ///< draws a layer's mask; without it the whole panel is white
  std::function<void(std::uint32_t, GreyRuns&)> add_greys = nullptr;
};

/// Homes, then prints. An opened cover ends the print.
inline Status print_layers(const Machine& machine, const SmallPrint& print) {
  const auto go_on = [](const Event&) { return Waiting::kContinue; };
  PLUMBLINE_TRY(machine.stage.home());
  for (std::uint32_t k = 0; k < print.layers; ++k) {
    auto mask = machine.mask.lend();
    if (!mask) return tl::unexpected<Error>(mask.error());
    if (print.draw) {
      print.draw(k, mask->image());
    } else {
      for (std::uint32_t row = 0; row < mask->image().rows(); ++row) {
        for (auto& word : mask->image().row(row)) word = ~std::uint64_t{0};
        mask->image().row(row).back() = mask->image().last_word_mask();
      }
    }
    if (print.add_greys) print.add_greys(k, mask->greys());
    const ZPosition height(print.layer_height * (k + 1));
    PLUMBLINE_TRY(machine.stage.move_to(height, print.speed));
    PLUMBLINE_TRY(machine.mask.present(std::move(*mask)));
    auto exposure = machine.lamp.begin_exposure(print.cure);
    if (!exposure) return tl::unexpected<Error>(exposure.error());
    PLUMBLINE_TRY(await(*exposure, machine.events, machine.clock, go_on));
    const auto report = exposure->finish();
    if (!report) return tl::unexpected<Error>(report.error());
    if (report->end != ExposureEnd::kTimeUp) return fail(ErrorCode::kCoverOpen, "layer %u was cut short", k);
    PLUMBLINE_TRY(machine.mask.blank());
    PLUMBLINE_TRY(machine.stage.move_to(height + print.lift, print.speed));
  }
  return {};
}

}  // namespace plumbline
