#pragma once
/// Light and parts made of masks, without a printer.

#include <cstdint>
#include <functional>
#include <vector>

#include "hal/sim/plant/cured_part.hpp"

namespace plumbline {

class Mask {
 public:
  Mask(std::uint32_t columns, std::uint32_t rows, const std::function<bool(std::uint32_t, std::uint32_t)>& white)
      : words_(BitImage::words_needed(columns, rows)), columns_(columns), rows_(rows) {
    const BitImage drawn(words_, columns, rows);
    for (std::uint32_t r = 0; r < rows; ++r) {
      for (std::uint32_t c = 0; c < columns; ++c) {
        if (white(c, r)) drawn.set(c, r);
      }
    }
  }
  ConstBitImage image() const { return {words_, columns_, rows_}; }

 private:
  std::vector<std::uint64_t> words_;
  std::uint32_t columns_, rows_;
};

/// Layer k of 0.05 mm.
inline CuredLayer light(int k, double dose) {
  return {.z = ZPosition(Distance::micrometres(50 * (k + 1))),
          .began = {},
          .ended = {},
          .asked = Dose(dose),
          .dose = Dose(dose)};
}

/// A part of layers of 0.05 mm that are white where a shape is at their middles, in pixels of 0.05 mm.
/// @param inside  at x, y, z, mm
inline CuredPart part_of(std::uint32_t columns, std::uint32_t rows, std::uint32_t layers, const Resin& resin,
                         const std::function<double(std::uint32_t)>& dose,
                         const std::function<bool(double, double, double)>& inside) {
  CuredPart part(columns, rows, 0.05, 0.05, {.traction_kpa = 0, .line_force_n_mm = 0, .suction_kpa = 0}, true);
  for (std::uint32_t k = 0; k < layers; ++k) {
    const Mask mask(columns, rows, [&](std::uint32_t c, std::uint32_t r) {
      return inside((c + 0.5) * 0.05, (r + 0.5) * 0.05, (k + 0.5) * 0.05);
    });
    const CuredLayer layer = light(static_cast<int>(k), dose(k));
    part.expose(layer.z, mask.image(), {}, {}, layer.asked, layer.dose, resin);
    part.complete_layer(k, 0.05, false);
  }
  return part;
}

}  // namespace plumbline
