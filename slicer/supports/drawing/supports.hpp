#pragma once
/// The supports of a print: a short list of struts.

#include <algorithm>
#include <cmath>
#include <cstdint>
#include <span>

#include "slicer/core/print_grid.hpp"
#include "slicer/supports/drawing/disc.hpp"

namespace plumbline::inline slicer {

/// What a strut is for.
enum class StrutKind : std::uint8_t {
  kTip,     ///< the end of a head, in the object; one for each place that is held
  kHead,    ///< cone from a tip to its pillar or bridge
  kBridge,  ///< from a head to a pillar beside it
  kPillar,  ///< upright
  kBrace,   ///< between two pillars
  kBase,    ///< cone at the foot of a pillar, or pad below a small foot
  kRaft,    ///< on the plate
};
inline constexpr std::uint32_t kStrutKinds = 7;

/// A round rod from the underside of layer `first` to the top of layer `end` - 1. Its section by a layer is a disc; that of a
/// lying strut is the whole rod. Both ends are centres of pixels. A strut of no layers (`first == end`) is not printed.
struct Strut {
  std::uint16_t column0 = 0, row0 = 0;     ///< the lower end
  std::uint16_t column1 = 0, row1 = 0;     ///< the upper end
  std::uint16_t first = 0, end = 0;        ///< layers
  std::uint16_t radius0 = 0, radius1 = 0;  ///< at the underside and at the top, micrometres
  StrutKind kind = StrutKind::kPillar;
  std::uint8_t lies = 0;  ///< 1: it lies

  bool is_in(std::uint32_t layer) const { return first <= layer && layer < end; }
  bool operator==(const Strut&) const = default;
};

/// A strut's disc in a layer.
struct StrutSection {
  std::uint32_t column = 0, row = 0;
  Nanometres radius = 0;
};

/// The section at a layer's middle; of a lying strut the one round its lower end.
/// @param layer  that `strut` is in
inline StrutSection section_of(const Strut& strut, std::uint32_t layer) {
  const bool is_upright = strut.column0 == strut.column1 && strut.row0 == strut.row1 && strut.radius0 == strut.radius1;
  if (is_upright) return {strut.column0, strut.row0, 1000 * std::int64_t{strut.radius0}};
  const std::int64_t way = 2 * std::int64_t{layer - strut.first} + 1;
  const std::int64_t whole = 2 * std::int64_t{strut.end - strut.first};
  const auto between = [&](std::int64_t from, std::int64_t to) {  // rounded to the nearest, both ends alike
    const std::int64_t twice = 2 * way * (to - from);
    return from + (twice >= 0 ? twice + whole : twice - whole) / (2 * whole);
  };
  const std::int64_t radius =
      1000 * std::int64_t{strut.radius0} + 1000 * (std::int64_t{strut.radius1} - strut.radius0) * way / whole;
  if (strut.lies != 0) return {strut.column0, strut.row0, radius};
  return {static_cast<std::uint32_t>(between(strut.column0, strut.column1)),
          static_cast<std::uint32_t>(between(strut.row0, strut.row1)), radius};
}

/// Calls visit(row, begin, end) for the pixels of a lying strut between its ends, as far as they are on the grid: columns [begin, end).
/// They are the rectangle |x dy - y dx| <= radius length, 0 <= x dx + y dy <= length^2 round the line from its lower end, (0, 0), to its upper
/// one, (dx, dy).
template <class Visit>
void for_each_band_span(const PixelPitch& pitch, const Strut& strut, Nanometres radius, std::uint32_t columns,
                        std::uint32_t rows, Visit visit) {
  const auto px = static_cast<double>(pitch.x);
  const auto py = static_cast<double>(pitch.y);
  const auto r = static_cast<double>(radius);
  const double dx = (strut.column1 - strut.column0) * px;
  const double dy = (strut.row1 - strut.row0) * py;
  const double square = dx * dx + dy * dy;
  if (!(square > 0)) return;
  const double length = std::sqrt(square);
  // Rows of the rectangle's corners; and in row y columns |x - y along| <= side, least <= x - y across <= most.
  const double beyond = r * std::abs(dx) / length;
  const double along = dy == 0 ? 0 : dx / dy * py / px;
  const double across = dx == 0 ? 0 : -dy / dx * py / px;
  const double side = dy == 0 ? 1e300 : r * length / std::abs(dy) / px;
  const double least = dx == 0 ? -1e300 : std::min(0.0, square / dx) / px;
  const double most = dx == 0 ? 1e300 : std::max(0.0, square / dx) / px;
  const auto low = static_cast<std::int64_t>(std::ceil((std::min(0.0, dy) - beyond) / py));
  const auto high = static_cast<std::int64_t>(std::floor((std::max(0.0, dy) + beyond) / py));
  const std::int64_t from_row = std::max(low, -std::int64_t{strut.row0});
  const std::int64_t to_row = std::min(high, std::int64_t{rows} - 1 - strut.row0);
  for (std::int64_t y = from_row; y <= to_row; ++y) {
    const auto row = static_cast<double>(y);
    const double begin = strut.column0 + std::max(row * along - side, row * across + least);
    const double end = strut.column0 + std::min(row * along + side, row * across + most);
    if (end < 0 || begin > columns - 1.0) continue;
    auto first = static_cast<std::uint32_t>(std::max(0.0, begin));
    if (first < begin) ++first;
    const auto last = static_cast<std::uint32_t>(std::min(columns - 1.0, end));
    if (first <= last) visit(static_cast<std::uint32_t>(strut.row0 + y), first, last + 1);
  }
}

/// Calls visit(row, begin, end) for the pixels of a strut in a layer, as far as they are on the grid: columns [begin, end). Spans of a lying
/// strut overlap.
/// @param layer  that `strut` is in
template <class Visit>
void for_each_strut_span(const PixelPitch& pitch, const Strut& strut, std::uint32_t layer, std::uint32_t columns,
                         std::uint32_t rows, Visit visit) {
  const StrutSection disc = section_of(strut, layer);
  for_each_disc_span(pitch, disc.column, disc.row, disc.radius, columns, rows, visit);
  if (strut.lies == 0 || (strut.column0 == strut.column1 && strut.row0 == strut.row1)) return;
  for_each_disc_span(pitch, strut.column1, strut.row1, disc.radius, columns, rows, visit);
  for_each_band_span(pitch, strut, disc.radius, columns, rows, visit);
}

struct Supports {
  std::span<const Strut> list;  ///< by first layer; the arena's
  PixelPitch pitch;

  bool empty() const { return list.empty(); }
  /// Places that are held.
  std::uint32_t tips() const {
    return static_cast<std::uint32_t>(
        std::count_if(list.begin(), list.end(), [](const Strut& strut) { return strut.kind == StrutKind::kTip; }));
  }
};

}  // namespace plumbline::inline slicer
