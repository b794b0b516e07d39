#include "slicer/supports/held_area.hpp"

#include <algorithm>

#include "slicer/core/numbers/degrees.hpp"

namespace plumbline::inline slicer {
namespace {

/// Of kSteps steps, kStepsToCorners go to the corners too: 5 / 12 is close to sqrt(2) - 1, the ratio of a regular octagon.
constexpr std::uint64_t kSteps = 12;
constexpr std::uint64_t kStepsToCorners = 5;

Nanometres ceil_divide(Nanometres a, Nanometres b) { return (a + b - 1) / b; }

}  // namespace

Expected<HeldArea> HeldArea::create(const PrintGrid& grid, const SupportSettings& settings, Arena& arena) {
  HeldArea area;
  area.pitch_ = PixelPitch(grid);
  area.reach_ = nanometres(settings.overhang_span / 2);
  const SineCosine angle = sine_cosine(settings.overhang_angle);
  area.growth_ =
      std::max<Nanometres>(1, nanometres(static_cast<double>(grid.layer_height_mm) * angle.cosine / angle.sine));
  area.settle_layers_ = static_cast<std::uint32_t>(ceil_divide(area.reach_, area.growth_));
  for (BitImage* image : {&area.held_, &area.settling_, &area.grown_}) {
    auto words = arena.take_top<std::uint64_t>(BitImage::words_needed(grid.columns, grid.rows), "supports");
    PLUMBLINE_TRY(words);
    *image = BitImage(*words, grid.columns, grid.rows);
    image->clear();
  }
  auto open = arena.take_top<std::uint64_t>(BitImage::words_needed(grid.rows, 1), "supports");
  PLUMBLINE_TRY(open);
  area.open_ = BitImage(*open, grid.rows, 1);
  auto bridge = Disc::create(area.pitch_, area.reach_, arena);
  PLUMBLINE_TRY(bridge);
  area.bridge_ = *bridge;
  return area;
}

std::size_t HeldArea::bytes_needed(const PrintGrid& grid) {
  return 3 * Arena::rounded(BitImage::words_needed(grid.columns, grid.rows) * sizeof(std::uint64_t)) +
         Arena::rounded(BitImage::words_needed(grid.rows, 1) * sizeof(std::uint64_t)) +
         Disc::bytes_needed(PixelPitch(grid), nanometres(kLongestSpan / 2));
}

void HeldArea::begin(ConstBitImage mask) {
  std::copy(mask.words().begin(), mask.words().end(), held_.words().begin());
  std::copy(mask.words().begin(), mask.words().end(), settling_.words().begin());
}

void HeldArea::next_layer(std::uint32_t layer, ConstBitImage mask, const Window& window) {
  window_ = window;
  const bool settles = layer % settle_layers_ == 0;
  bool any_open = false;
  open_.clear();
  for (std::uint32_t r = window_.row; r < window_.row_end; ++r) {
    const auto line = mask.row(r);
    const auto held = held_.row(r);
    const auto settling = settling_.row(r);
    std::uint64_t open = 0;
    for (std::uint32_t w = window_.word; w < window_.word_end; ++w) {
      held[w] &= line[w];
      settling[w] &= line[w];
      if (settles) {
        held[w] |= settling[w];
        settling[w] = line[w];
      }
      open |= held[w] ^ line[w];
    }
    if (open == 0) continue;
    open_.set(r, 0);
    any_open = true;
  }
  if (any_open) grow(layer, mask);
}

void HeldArea::grow(std::uint32_t layer, ConstBitImage mask) {
  const auto steps = [&](Nanometres pitch) {
    const Nanometres due = growth_ * layer / pitch - growth_ * (layer - 1) / pitch;
    return std::min(due, reach_ / pitch);  // a larger step would hold nothing more
  };
  const Nanometres columns = steps(pitch_.x);
  const Nanometres rows = steps(pitch_.y);
  for (Nanometres i = 0; i < std::max(columns, rows); ++i) {
    const bool both = i < columns && i < rows;
    if (both) ++steps_;
    const bool corners = both && steps_ * kStepsToCorners / kSteps != (steps_ - 1) * kStepsToCorners / kSteps;
    grow_one(i < columns, i < rows, corners, mask);
  }
}

void HeldArea::grow_one(bool columns, bool rows, bool corners, ConstBitImage mask) {
  const auto widened = [](std::span<const std::uint64_t> line, std::uint32_t w) {
    std::uint64_t wide = line[w] | line[w] << 1 | line[w] >> 1;
    if (w > 0) wide |= line[w - 1] >> 63;
    if (w + 1 < line.size()) wide |= line[w + 1] << 63;
    return wide;
  };
  // New pixels must not grow in the same step: a row is written once the next one has been read.
  for (std::uint32_t r = window_.row; r <= window_.row_end; ++r) {
    if (r < window_.row_end && open_.at(r, 0)) {
      const auto line = mask.row(r);
      const std::span<const std::uint64_t> held = held_.row(r);
      const std::span<const std::uint64_t> above = r > 0 ? held_.row(r - 1) : held;
      const std::span<const std::uint64_t> under = r + 1 < held_.rows() ? held_.row(r + 1) : held;
      const auto grown = grown_.row(r);
      for (std::uint32_t w = window_.word; w < window_.word_end; ++w) {
        grown[w] = 0;
        const std::uint64_t open = line[w] & ~held[w];
        if (open == 0) continue;
        if (columns) grown[w] |= open & widened(held, w);
        if (rows) grown[w] |= open & (above[w] | under[w]);
        if (corners) grown[w] |= open & (widened(above, w) | widened(under, w));
      }
    }
    if (r == window_.row || !open_.at(r - 1, 0)) continue;
    const auto grown = grown_.row(r - 1);
    const auto held = held_.row(r - 1);
    for (std::uint32_t w = window_.word; w < window_.word_end; ++w) held[w] |= grown[w];
  }
}

void HeldArea::add_disc(std::uint32_t column, std::uint32_t row, Nanometres radius, ConstBitImage mask) {
  for_each_disc_span(pitch_, column, row, radius, mask.columns(), mask.rows(),
                     [&](std::uint32_t r, std::uint32_t begin, std::uint32_t end) {
                       for_each_word(begin, end, [&](std::uint32_t w, std::uint64_t bits) {
                         held_.row(r)[w] |= mask.row(r)[w] & bits;
                       });
                     });
}

std::uint64_t HeldArea::unheld(std::uint32_t row, std::uint32_t word, std::uint64_t pixels) const {
  return pixels & ~held_.row(row)[word];
}

void HeldArea::take_out(std::uint32_t column, std::uint32_t row) {
  const std::uint64_t bit = std::uint64_t{1} << (column % 64);
  held_.row(row)[column / 64] &= ~bit;
  settling_.row(row)[column / 64] &= ~bit;
}

void HeldArea::drop_what_is_near(BitImage fresh, ConstBitImage marks) const {
  for (std::uint32_t r = window_.row; r < window_.row_end; ++r) {
    const auto line = fresh.row(r);
    for_each_marked(marks.row(r), [&](std::uint32_t w) {
      if (line[w] != 0) line[w] &= ~bridge_.near(held_, r, w, line[w]);
    });
  }
}

}  // namespace plumbline::inline slicer
