#pragma once
/// A small simulated printer for tests.

#include <initializer_list>
#include <random>
#include <string>
#include <vector>

#include "hal/sim/plant/plant.hpp"

namespace plumbline {

/// 5 cm x 3 cm of panel in 100 x 60 pixels, and `faults`.
inline PlantSettings small_printer(std::initializer_list<std::string> faults = {}) {
  PlantSettings settings;
  settings.panel.columns = 100;
  settings.panel.rows = 60;
  settings.panel.pitch_x_mm = settings.panel.pitch_y_mm = 0.5;
  for (const auto& text : faults) settings.faults.push_back(parse_fault(text).value());
  return settings;
}

inline std::vector<std::string> texts_of(std::span<const Objection> objections) {
  std::vector<std::string> texts;
  for (const Objection& objection : objections) texts.push_back(to_string(objection));
  return texts;
}

inline std::vector<ObjectionKind> kinds_of(std::span<const Objection> objections) {
  std::vector<ObjectionKind> kinds;
  for (const Objection& objection : objections) kinds.push_back(objection.kind);
  return kinds;
}

/// A mask that differs from layer to layer. Every other row is white, so whatever is beside it is held.
inline void draw_random(std::uint32_t layer, BitImage image) {
  std::mt19937_64 random(layer);
  for (std::uint32_t row = 0; row < image.rows(); ++row) {
    for (auto& word : image.row(row)) {
      const std::uint64_t half = random();
      word = row % 2 == 0 ? ~std::uint64_t{0} : half & random();
    }
    image.row(row).back() &= image.last_word_mask();
  }
}

}  // namespace plumbline
