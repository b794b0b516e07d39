#include "slicer/layers/rrep_edit.hpp"

#include <algorithm>

#include "slicer/layers/layer_stream.hpp"

namespace plumbline::inline slicer {
namespace {

constexpr std::uint32_t kLastLayers = 16;  ///< layers searched first, from the top; affects the cost only

/// Sorts the toggles and keeps one of each that occurs an odd number of times.
std::span<RRepToggle> distinct(std::span<RRepToggle> toggles, std::uint32_t layers) {
  std::sort(toggles.begin(), toggles.end());
  std::size_t count = 0;
  for (const RRepToggle& toggle : toggles) {
    if (toggle.layer >= layers) continue;
    if (count > 0 && toggles[count - 1] == toggle) {
      --count;
    } else {
      toggles[count++] = toggle;
    }
  }
  return toggles.first(count);
}

}  // namespace

Expected<EmptyLayers> find_empty_layers(const RRep& rrep, Arena& arena) {
  const std::size_t mark = arena.bottom_mark();
  auto stream = LayerStream::create(rrep, arena);
  EmptyLayers empty;
  if (stream) {
    const std::uint32_t layers = rrep.grid.layers;
    const auto prints = [&](std::uint32_t layer) { return stream->mask(layer).count() > 0; };
    while (empty.below < layers && !prints(empty.below)) ++empty.below;
    // Masks are made upwards: look at the last few first, and at more of them only if those are all empty.
    std::uint32_t end = empty.below;  // beyond the last layer that prints
    for (std::uint32_t last = kLastLayers; end == empty.below && end < layers; last *= 4) {
      for (std::uint32_t k = std::max(empty.below, layers - std::min(layers, last)); k < layers; ++k) {
        if (prints(k)) end = k + 1;
      }
    }
    empty.above = layers - end;
  }
  arena.release_bottom(mark);
  if (!stream) return tl::unexpected<Error>(stream.error());
  return empty;
}

Status toggle_crossings(RRep& rrep, std::span<RRepToggle> toggles, Arena& arena) {
  const std::span<const RRepToggle> added = distinct(toggles, rrep.grid.layers);
  // rrep is the newest block at the bottom, so this block continues it, but for the rounding of blocks.
  auto more = arena.take_bottom<std::uint32_t>(added.size(), "R-Rep");
  if (!more) return tl::unexpected<Error>(more.error());
  const CrossingPacking packing(rrep.grid);
  std::uint32_t* const packed = const_cast<std::uint32_t*>(rrep.packed.data());
  std::uint32_t* const first = const_cast<std::uint32_t*>(rrep.first.data());

  // Merges from the last crossing down into the room behind: nothing is overwritten before it is read.
  const std::size_t room = rrep.packed.size() + added.size();
  std::size_t to = room;
  std::size_t toggle = added.size();
  std::uint32_t from = first[rrep.grid.layers];
  for (std::uint32_t layer = rrep.grid.layers; layer-- > 0;) {
    const std::size_t end = to;
    const std::uint32_t begin = first[layer];
    while (from > begin || (toggle > 0 && added[toggle - 1].layer == layer)) {
      const bool is_added = toggle > 0 && added[toggle - 1].layer == layer;
      if (is_added && from > begin && packing.pixel(packed[from - 1]) == added[toggle - 1].pixel) {
        --from;
        --toggle;
      } else if (is_added && (from == begin || added[toggle - 1].pixel > packing.pixel(packed[from - 1]))) {
        packed[--to] = packing.packed(added[--toggle].pixel);
      } else {
        packed[--to] = packed[--from];
      }
    }
    first[layer + 1] = static_cast<std::uint32_t>(end);
  }
  for (std::uint32_t k = 1; k <= rrep.grid.layers; ++k) first[k] -= static_cast<std::uint32_t>(to);
  std::copy(packed + to, packed + room, packed);
  rrep.packed = {packed, room - to};
  arena.trim_bottom(packed, rrep.packed.size_bytes());
  return {};
}

Expected<EmptyLayers> trim_empty_layers(RRep& rrep, Arena& arena, std::optional<EmptyLayers> known) {
  const Expected<EmptyLayers> empty = known ? Expected<EmptyLayers>(*known) : find_empty_layers(rrep, arena);
  PLUMBLINE_TRY(empty);
  const auto [below, above] = *empty;
  if (below == rrep.grid.layers) {
    return fail(
        ErrorCode::kNoSurface,
        "no layer has a pixel: the scan is too thin to be printed, such as a plane or a needle.\tCheck its unit, or "
        "scan the object from all sides");
  }
  if (below > 0) {
    // Crossings of the removed layers move to the first layer that stays.
    const ArenaScope scope(arena);
    const std::uint32_t crossings = rrep.first[below];
    auto moves = arena.take_top<RRepToggle>(2 * std::size_t{crossings}, "R-Rep");
    PLUMBLINE_TRY(moves);
    const CrossingPacking packing(rrep.grid);
    std::size_t move = 0;
    for (std::uint32_t layer = 0; layer < below; ++layer) {
      for (std::uint32_t i = rrep.first[layer]; i < rrep.first[layer + 1]; ++i) {
        (*moves)[move++] = {layer, packing.pixel(rrep.packed[i])};
        (*moves)[move++] = {below, packing.pixel(rrep.packed[i])};
      }
    }
    PLUMBLINE_TRY(toggle_crossings(rrep, *moves, arena));
  }
  rrep.grid.layers -= below + above;
  rrep.first = rrep.first.subspan(below, rrep.grid.layers + 1);
  rrep.packed = rrep.packed.first(rrep.first.back());
  arena.trim_bottom(rrep.packed.data(), rrep.packed.size_bytes());
  return *empty;
}

void cut_layers(RRep& rrep, const EmptyLayers& cut) {
  const std::uint32_t below = cut.below;
  rrep.grid.layers -= below + cut.above;
  if (below > 0) {
    // Crossings of the layers that go, and of the first that stays. An odd number of one pixel leaves one.
    std::uint32_t* const packed = const_cast<std::uint32_t*>(rrep.packed.data());
    std::uint32_t* const first = const_cast<std::uint32_t*>(rrep.first.data());
    const CrossingPacking packing(rrep.grid);
    const std::uint32_t own = first[below], end = first[below + 1];
    for (std::uint32_t i = 0; i < own; ++i) packed[i] = packing.packed(packing.pixel(packed[i]));
    std::sort(packed, packed + end);
    std::uint32_t kept = 0;
    for (std::uint32_t i = 0; i < end; ++i) {
      if (kept > 0 && packing.pixel(packed[kept - 1]) == packing.pixel(packed[i])) {
        --kept;
      } else {
        packed[kept++] = packed[i];
      }
    }
    std::copy(packed + end, packed + rrep.packed.size(), packed + kept);
    first[below] = 0;
    for (std::size_t k = below + std::size_t{1}; k < rrep.first.size(); ++k) first[k] -= end - kept;
  }
  rrep.first = rrep.first.subspan(below, rrep.grid.layers + std::size_t{1});
  rrep.packed = rrep.packed.first(rrep.first.back());
}

Status raise_object(RRep& rrep, std::uint32_t layers, Arena& arena) {
  const auto first = arena.take_bottom<std::uint32_t>(rrep.first.size() + layers, "R-Rep");
  PLUMBLINE_TRY(first);
  std::fill(first->begin(), first->begin() + layers, 0U);
  std::copy(rrep.first.begin(), rrep.first.end(), first->begin() + layers);
  rrep.first = *first;
  rrep.grid.layers += layers;
  return {};
}

}  // namespace plumbline::inline slicer
