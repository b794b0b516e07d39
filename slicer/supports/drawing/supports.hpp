#pragma once
/// The supports of a print: a short list of struts.

#include <algorithm>
#include <cmath>
#include <cstdint>
#include <span>

#include "slicer/core/print_grid.hpp"
#include "slicer/supports/drawing/disc.hpp"

namespace plumbline {

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

/// Calls visit(row, begin, end) for the pixels of a lying strut, as far as they are on the grid: columns [begin, end).
template <class Visit>
void for_each_lying_span(const PixelPitch& pitch, const Strut& strut, Nanometres radius, std::uint32_t columns,
                         std::uint32_t rows, Visit visit) {
  const auto px = static_cast<double>(pitch.x);
  const auto py = static_cast<double>(pitch.y);
  const auto r = static_cast<double>(radius);
  const double dx = (strut.column1 - strut.column0) * px;
  const double dy = (strut.row1 - strut.row0) * py;
  const double length = std::sqrt(dx * dx + dy * dy);
  const auto reach = static_cast<std::int64_t>(radius / pitch.y);
  const std::int64_t low = std::max<std::int64_t>(0, std::min(strut.row0, strut.row1) - reach);
  const std::int64_t high = std::min<std::int64_t>(rows - 1, std::max(strut.row0, strut.row1) + reach);
  for (std::int64_t row = low; row <= high; ++row) {
    double begin = 1e300;
    double end = -1e300;
    const auto hold = [&](double from, double to) {
      begin = std::min(begin, from);
      end = std::max(end, to);
    };
    const double y = static_cast<double>(row - strut.row0) * py;
    if (y * y <= r * r) {
      const double half = std::sqrt(r * r - y * y);
      hold(-half, half);
    }
    if ((y - dy) * (y - dy) <= r * r) {
      const double half = std::sqrt(r * r - (y - dy) * (y - dy));
      hold(dx - half, dx + half);
    }
    // Between the ends: |x dy - y dx| <= r length and 0 <= x dx + y dy <= length^2.
    double from = -1e300;
    double to = 1e300;
    const auto limit = [&](double factor, double least, double most) {  // least <= factor x <= most
      if (factor == 0) {
        if (least > 0 || most < 0) to = -1e300;
        return;
      }
      from = std::max(from, (factor > 0 ? least : most) / factor);
      to = std::min(to, (factor > 0 ? most : least) / factor);
    };
    limit(dy, y * dx - r * length, y * dx + r * length);
    limit(dx, -y * dy, length * length - y * dy);
    if (from <= to && length > 0) hold(from, to);
    if (begin > end) continue;
    const double first = std::max(0.0, std::ceil(begin / px) + strut.column0);
    const double last = std::min(columns - 1.0, std::floor(end / px) + strut.column0);
    if (first <= last) {
      visit(static_cast<std::uint32_t>(row), static_cast<std::uint32_t>(first), static_cast<std::uint32_t>(last) + 1);
    }
  }
}

/// Calls visit(row, begin, end) for the pixels of a strut in a layer, as far as they are on the grid: columns [begin, end).
/// @param layer  that `strut` is in
template <class Visit>
void for_each_strut_span(const PixelPitch& pitch, const Strut& strut, std::uint32_t layer, std::uint32_t columns,
                         std::uint32_t rows, Visit visit) {
  const StrutSection disc = section_of(strut, layer);
  if (strut.lies != 0) return for_each_lying_span(pitch, strut, disc.radius, columns, rows, visit);
  for_each_disc_span(pitch, disc.column, disc.row, disc.radius, columns, rows, visit);
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

}  // namespace plumbline
