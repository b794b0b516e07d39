#pragma once
/// How even the lamp is, and what of its light a panel lets through so that all places get that of the darkest:
///
///     g(x, y) = min(I) / I(x, y) where I was measured, bilinear in between
///
/// as DrLCD has it. Masks stay as they were asked for: g is multiplied where pixels are packed for the panel.

#include <algorithm>
#include <array>
#include <bit>
#include <cmath>
#include <cstdint>
#include <span>

#include "slicer/core/bit_spans.hpp"
#include "slicer/core/grey_runs.hpp"

namespace plumbline::inline hal {

/// What was measured at the middles of equal rectangles of the panel. Beyond the outermost middles the light is as there.
struct LampMap {
  static constexpr std::uint32_t kMostSide = 16;
  static constexpr double kMostSpread = 2;  ///< brightest place to darkest

  std::uint32_t columns = 0, rows = 0;                               ///< of rectangles; 0: nothing was measured
  std::array<double, std::size_t{kMostSide}* kMostSide> light = {};  ///< [row * columns + column], any unit, above 0

  bool known() const { return columns > 0; }
  std::span<const double> all() const { return std::span(light).first(std::size_t{columns} * rows); }
  double darkest() const { return *std::ranges::min_element(all()); }
  double spread() const { return *std::ranges::max_element(all()) / darkest(); }
  /// Light in times the darkest, bilinear. @param across, along  0 to 1 of the panel's columns and rows @pre known()
  double at(double across, double along) const {
    const double x = std::clamp(across * columns - 0.5, 0.0, columns - 1.0);
    const double y = std::clamp(along * rows - 0.5, 0.0, rows - 1.0);
    const auto left = static_cast<std::uint32_t>(x), top = static_cast<std::uint32_t>(y);
    const auto of_row = [&](std::uint32_t row) {
      const std::size_t first = std::size_t{std::min(row, rows - 1)} * columns;
      return std::lerp(light[first + left], light[first + std::min(left + 1, columns - 1)], x - left);
    };
    return std::lerp(of_row(top), of_row(top + 1), y - top) / darkest();
  }
};

/// g of every pixel in integers, so that it is the same on every machine. Made once, when the panel is opened.
class LampShares {
 public:
  static constexpr std::uint32_t kAll = 1U << 16U;
  /// A level as the panel is to let it through.
  /// @param share  of kAll
  static constexpr std::uint8_t scaled(std::uint32_t level, std::uint32_t share) {
    return static_cast<std::uint8_t>((level * share + kAll / 2) / kAll);
  }

  LampShares() = default;
  /// @param columns, rows  of the panel
  LampShares(const LampMap& map, std::uint32_t columns, std::uint32_t rows)
      : across_{columns, map.columns}, along_{rows, map.rows} {
    for (std::size_t i = 0; i < map.all().size(); ++i) {
      shares_[i] = static_cast<std::uint32_t>(std::lround(kAll * (map.darkest() / map.light[i])));
    }
  }
  bool known() const { return across_.cells > 0; }

 private:
  /// Pixels along an axis, and what was measured along it. Stretch k lies between the middles k - 1 and k, the first and the last one between
  /// an edge and a middle. In stretches a pixel's middle is at place() / (2 pixels).
  struct Axis {
    std::uint32_t pixels = 1, cells = 0;
    std::uint32_t place(std::uint32_t pixel) const { return (2 * pixel + 1) * cells + pixels; }
    /// The first pixel of a stretch.
    std::uint32_t first(std::uint32_t k) const { return k == 0 ? 0 : (pixels * (2 * k - 1) + cells - 1) / (2 * cells); }
    /// The rectangle at the beginning of a stretch.
    std::uint32_t cell(std::uint32_t k) const { return std::min(std::max(k, 1U) - 1, cells - 1); }
  };

 public:
  /// g along a row of the panel.
  class Row {
   public:
    Row(const LampShares& shares, std::uint32_t row) : axis_(shares.across_) {
      const Axis& along = shares.along_;
      const std::uint64_t whole = 2 * along.pixels, k = along.place(row) / whole, part = along.place(row) % whole;
      const auto above = shares.of_row(along.cell(static_cast<std::uint32_t>(k)));
      const auto below = shares.of_row(along.cell(static_cast<std::uint32_t>(k) + 1));
      for (std::uint32_t c = 0; c < axis_.cells; ++c) {
        shares_[c] = static_cast<std::uint32_t>(((whole - part) * above[c] + part * below[c]) / whole);
      }
    }
    void go_to(std::uint32_t column) {
      const std::uint32_t k = axis_.place(column) / (2 * axis_.pixels), first = axis_.first(k);
      const std::int64_t from = shares_[axis_.cell(k)], more = (shares_[axis_.cell(k + 1)] - from) * kFine;
      // Rounded towards 0, so that it never passes the middle that it goes to, and off by less than 1 of kAll across a panel.
      step_ = more * axis_.cells / axis_.pixels;
      const std::int64_t into = axis_.place(first) - std::int64_t{2} * axis_.pixels * k;
      share_ = from * kFine + more * into / (2 * axis_.pixels) + (column - first) * step_;
      column_ = column;
      end_ = axis_.first(k + 1);
    }
    /// Of kAll at the column at hand; goes on to the next.
    std::uint32_t next() {
      if (column_ == end_) go_to(column_);
      ++column_;
      const auto share = static_cast<std::uint64_t>(share_);
      share_ += step_;
      return static_cast<std::uint32_t>(share / kFine);
    }

   private:
    static constexpr std::int64_t kFine = 1 << 14;
    Axis axis_;
    std::array<std::uint32_t, LampMap::kMostSide> shares_ = {};  ///< of the row at the measured columns
    std::int64_t share_ = 0, step_ = 0;                          ///< of kAll * kFine
    std::uint32_t column_ = 0, end_ = 0;
  };

 private:
  std::span<const std::uint32_t> of_row(std::uint32_t row) const {
    return std::span(shares_).subspan(std::size_t{row} * across_.cells, across_.cells);
  }

  Axis across_, along_;
  std::array<std::uint32_t, std::size_t{LampMap::kMostSide}* LampMap::kMostSide> shares_ = {};
};

/// Calls visit(run, row of shares at the run) for all pixels of a mask that get light, ascending: its grey runs, and what is white between
/// them as runs of kFullLevel.
/// @param greys  ascending
template <class Visit>
void for_each_lit_run(ConstBitImage mask, std::span<const GreyRun> greys, const LampShares& shares, Visit visit) {
  auto grey = greys.begin();
  for (std::uint32_t r = 0; r < mask.rows(); ++r) {
    const std::uint32_t first = r * mask.columns(), end = first + mask.columns();
    const bool has_grey = grey != greys.end() && grey->pixel < end;
    if (!has_grey && is_blank(mask.row(r))) continue;
    LampShares::Row row(shares, r);
    std::uint32_t next = first;  // pixel that was not visited yet
    const auto show = [&](const GreyRun& run) {
      row.go_to(run.pixel - first);
      visit(run, row);
      next = run.end();
    };
    const auto show_up_to = [&](std::uint32_t white, std::uint32_t white_end) {
      for (; grey != greys.end() && grey->pixel < white_end; ++grey) {
        white = std::max(white, next);
        if (white < grey->pixel) show({white, static_cast<std::uint16_t>(grey->pixel - white), kFullLevel});
        show(*grey);
      }
      white = std::max(white, next);
      if (white < white_end) show({white, static_cast<std::uint16_t>(white_end - white), kFullLevel});
    };
    for_each_run(mask.row(r), [&](std::uint32_t from, std::uint32_t to) { show_up_to(first + from, first + to); });
    show_up_to(end, end);
  }
}

}  // namespace plumbline::inline hal
