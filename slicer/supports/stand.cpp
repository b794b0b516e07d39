#include "slicer/supports/stand.hpp"

#include <algorithm>
#include <cmath>
#include <optional>

#include "slicer/layers/layer_stream.hpp"
#include "slicer/layers/rrep_edit.hpp"
#include "slicer/supports/window.hpp"

namespace plumbline::inline slicer {
namespace {

/// Of the layers above those that may be cut off, every fourth is measured.
constexpr std::uint32_t kMeasuredLayers = 4;

std::uint64_t pixels_in(ConstBitImage mask, const Window& window) {
  std::uint64_t sum = 0;
  for (std::uint32_t r = window.row; r < window.row_end; ++r) {
    for (const std::uint64_t word : mask.row(r).subspan(window.word, window.word_end - window.word)) {
      if (word != 0) sum += count_ones(word);
    }
  }
  return sum;
}

/// How the object stands on the first layer that holds it on the plate; nothing if none does.
Expected<std::optional<Stand>> on_flat_layer(const RRep& rrep, Arena& arena) {
  const std::size_t mark = arena.bottom_mark();
  auto stream = LayerStream::create(rrep, arena);
  PLUMBLINE_TRY(stream);
  const Window window = window_of(rrep);
  const double most = std::floor(std::min(kMostSunk_mm / static_cast<double>(rrep.grid.layer_height_mm) + 0.5,
                                          std::max(0.0, rrep.grid.layers / kSunkShare - 0.5)));
  const auto candidates = static_cast<std::uint32_t>(most) + 1;
  std::uint64_t largest = 0;
  for (std::uint32_t k = 0; k < rrep.grid.layers; k += kMeasuredLayers) {
    largest = std::max(largest, pixels_in(stream->mask(k), window));
  }
  const auto rise =
      static_cast<std::uint32_t>(std::floor(kFlatRise_mm / static_cast<double>(rrep.grid.layer_height_mm) + 0.5));
  Stand stand{.flat = true};
  for (; stand.sunk < candidates; ++stand.sunk) {
    const std::uint64_t here = pixels_in(stream->mask(stand.sunk), window);
    if (here * kFlatShare >= largest &&
        here * 2 >= pixels_in(stream->mask(std::min(stand.sunk + rise, rrep.grid.layers - 1)), window)) {
      break;
    }
    stand.sunk_pixels += here;
  }
  arena.release_bottom(mark);
  return stand.sunk < candidates ? std::optional(stand) : std::nullopt;
}

}  // namespace

Expected<Stand> choose_stand(const RRep& rrep, const SupportSettings& settings, std::uint32_t most_layers,
                             Arena& arena) {
  const bool is_asked = settings.stand == SupportStand::kRaised;
  if (!is_asked) {
    const auto flat = on_flat_layer(rrep, arena);
    PLUMBLINE_TRY(flat);
    if (*flat) return **flat;
    if (!(lift_mm(settings) > 0)) return Stand{.flat = false};
  }
  const auto layer_height = static_cast<double>(rrep.grid.layer_height_mm);
  const auto lifted = static_cast<std::uint32_t>(std::ceil(lift_mm(settings) / layer_height - 1e-6));
  if (most_layers < rrep.grid.layers || lifted > most_layers - rrep.grid.layers) {
    return telling(
        Told(ToldCode::kTooHighOnSupports,
             {{Fact::kHeightMm, rrep.grid.layers * layer_height},
              {Fact::kLiftMm, lifted * layer_height},
              {Fact::kExcessMm,
               (rrep.grid.layers + lifted - std::min(most_layers, rrep.grid.layers + lifted)) * layer_height},
              {Fact::kLimitMm, most_layers * layer_height}}),
        fail(ErrorCode::kDoesNotFit,
             "the object is %.2f mm high%s supports lift it by %.2f mm: %.2f mm more than the printer's %.2f mm.\tMake "
             "it "
             "smaller, rotate it, or have it lifted less",
             rrep.grid.layers * layer_height, is_asked ? ", and" : " and has no flat underside, so",
             lifted * layer_height,
             (rrep.grid.layers + lifted - std::min(most_layers, rrep.grid.layers + lifted)) * layer_height,
             most_layers * layer_height));
  }
  return Stand{.lifted = lifted, .flat = is_asked ? std::nullopt : std::optional(false)};
}

Status stand_object(RRep& rrep, const Stand& stand, Arena& arena) {
  if (stand.sunk > 0) {
    const auto trimmed = trim_empty_layers(rrep, arena, EmptyLayers{.below = stand.sunk, .above = 0});
    PLUMBLINE_TRY(trimmed);
  }
  return stand.lifted > 0 ? raise_object(rrep, stand.lifted, arena) : Status();
}

}  // namespace plumbline::inline slicer
