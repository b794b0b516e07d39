#include "firmware/print/job/mask_renderer.hpp"

#include <algorithm>
#include <cmath>
#include <functional>

#include "firmware/io/mask_hash.hpp"
#include "slicer/core/bit_spans.hpp"

namespace plumbline::firmware {
namespace {

using Row = std::span<const std::uint64_t>;

/// Bits of word `w` whose left and right neighbours are white.
std::uint64_t between(Row row, std::size_t w) {
  const std::uint64_t before = w == 0 ? 0 : row[w - 1] >> 63;
  const std::uint64_t after = w + 1 == row.size() ? 0 : row[w + 1] << 63;
  return ((row[w] << 1) | before) & ((row[w] >> 1) | after);
}

void erode_row(Row above, Row at, Row below, bool eight, std::span<std::uint64_t> out) {
  for (std::size_t w = 0; w < at.size(); ++w) {
    std::uint64_t kept = at[w] & between(at, w) & above[w] & below[w];
    if (eight && kept != 0) kept &= between(above, w) & between(below, w);
    out[w] = kept;
  }
}

/// Leaves out the columns before `from`, of the mask and of its greys.
void show_from(std::uint32_t from, std::span<const GreyRun> all, BitImage out, GreyRuns& greys) {
  for (std::uint32_t r = 0; from > 0 && r < out.rows(); ++r) fill(out, r, 0, from, false);
  for (GreyRun run : all) {
    const std::uint32_t column = run.pixel % out.columns(), less = column < from ? from - column : 0;
    if (less >= run.count) continue;
    run.pixel += less;
    run.count = static_cast<std::uint16_t>(run.count - less);
    greys.add(run);
  }
}

}  // namespace

void erode(BitImage image, std::uint32_t steps, std::span<std::uint64_t> scratch) {
  const std::size_t stride = image.stride();
  for (std::uint32_t step = 0; step < steps; ++step) {
    // Copies of the old rows: each row is overwritten before the next one reads it.
    auto above = scratch.first(stride);
    auto at = scratch.subspan(stride, stride);
    const auto black = scratch.subspan(2 * stride, stride);
    std::fill(above.begin(), above.end(), 0);
    std::fill(black.begin(), black.end(), 0);
    for (std::uint32_t r = 0; r < image.rows(); ++r) {
      const auto row = image.row(r);
      std::copy(row.begin(), row.end(), at.begin());
      const Row below = r + 1 < image.rows() ? Row(image.row(r + 1)) : Row(black);
      erode_row(above, at, below, step % 2 == 1, row);
      std::swap(above, at);
    }
  }
}

Expected<MaskRenderer> MaskRenderer::create(MaskSource& source, const PrintPlan& plan, Arena& arena) {
  const auto rows = arena.take_bottom<std::uint64_t>(3 * BitImage::words_needed(source.grid().columns, 1), "masks");
  PLUMBLINE_TRY(rows);
  return MaskRenderer(source, plan, *rows);
}

std::size_t MaskRenderer::bytes_needed(const PrintGrid& grid) {
  return Arena::rounded(3 * BitImage::words_needed(grid.columns, 1) * sizeof(std::uint64_t));
}

/// Takes a layer's own mask from the source.
Status MaskRenderer::make(std::uint32_t layer) {
  layer_.reset();
  const auto mask = source_->mask(layer);
  PLUMBLINE_TRY(mask);
  mask_ = *mask;
  const auto pitch = (static_cast<double>(grid().pitch_x_mm) + static_cast<double>(grid().pitch_y_mm)) / 2;
  foot_steps_ = static_cast<std::uint32_t>(std::lround(plan_.elephant_foot.millimetres() / pitch));
  needs_ = {.foot = foot_steps_ > 0};
  const std::uint32_t n = grey_exposures_of(plan_, layer);
  for (const GreyRun& run : source_->greys()) needs_.shares |= 1U << share_of(run.level, n);
  needs_.shares &= ~(1U | 1U << (1U << n));  // black and white
  if (is_tested(plan_, layer)) needs_.strips = strips_with_pixels();
  hash_ = mask_hash(mask_, source_->greys());
  pixels_ = mask_.count() * plan_.steps.of(layer).step;
  layer_ = layer;
  return {};
}

std::uint32_t MaskRenderer::strips_with_pixels() const {
  const BitImage any(rows_.first(mask_.stride()), mask_.columns(), 1);  // of each column
  std::ranges::fill(any.words(), 0);
  for (std::uint32_t r = 0; r < mask_.rows(); ++r) {
    std::ranges::transform(any.words(), mask_.row(r), any.words().begin(), std::bit_or());
  }
  for (const GreyRun& run : source_->greys()) {
    const std::uint32_t begin = run.pixel % mask_.columns();
    fill(any, 0, begin, begin + run.count, true);
  }
  std::uint32_t strips = 0;
  for_each_run(any.row(0), [&](std::uint32_t begin, std::uint32_t end) {
    for (std::uint32_t c = 0; c < plan_.test.count; ++c) {
      const bool is_last = c + 1 == plan_.test.count;
      if (end > plan_.test.column(c) && (is_last || begin < plan_.test.column(c + 1))) strips |= 1U << c;
    }
  });
  return strips;
}

/// Makes grey pixels black or white as an exposure shows them.
void MaskRenderer::show_shares(const LayerExposure& exposure, std::uint32_t n, BitImage out) const {
  const std::uint32_t white = exposure.shares | 1U << (1U << n);
  for (const GreyRun& run : source_->greys()) {
    const std::uint32_t begin = run.pixel % out.columns();
    fill(out, run.pixel / out.columns(), begin, begin + run.count, (white >> share_of(run.level, n) & 1U) != 0);
  }
}

Expected<MaskFacts> MaskRenderer::render(std::uint32_t layer, std::chrono::nanoseconds lit, BitImage out,
                                         GreyRuns& greys) {
  using HostClock = std::chrono::steady_clock;
  MaskFacts facts;
  const auto start = HostClock::now();
  if (layer_ != layer) PLUMBLINE_TRY(make(layer));
  const auto made = HostClock::now();
  std::ranges::copy(mask_.words(), out.words().begin());
  const auto copied = HostClock::now();
  const LayerExposures exposures = exposures_of(plan_, layer, needs_);
  facts.exposure = exposures.at(lit);
  const LayerExposure& shown = exposures.all()[facts.exposure];
  facts.is_last = facts.exposure + 1 == exposures.count();
  facts.begin = exposures.begin(facts.exposure);
  facts.end = facts.begin + shown.time;
  const std::uint32_t n = grey_exposures_of(plan_, layer);
  if (shown.inside) {
    erode(out, foot_steps_, rows_);
  } else if (n > 0) {
    show_shares(shown, n, out);
  } else {
    show_from(shown.from, source_->greys(), out, greys);
  }
  facts.making = made - start + (HostClock::now() - copied);
  facts.copying = copied - made;
  facts.hash = hash_;
  facts.pixels = pixels_;
  return facts;
}

}  // namespace plumbline::firmware
