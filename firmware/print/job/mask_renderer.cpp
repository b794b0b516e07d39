#include "firmware/print/job/mask_renderer.hpp"

#include <algorithm>

#include "firmware/io/mask_hash.hpp"

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

Expected<MaskFacts> MaskRenderer::render(std::uint32_t layer, BitImage out, GreyRuns* greys) {
  using HostClock = std::chrono::steady_clock;
  MaskFacts facts;
  const auto start = HostClock::now();
  const auto mask = source_->mask(layer);
  PLUMBLINE_TRY(mask);
  const auto made = HostClock::now();
  std::copy(mask->words().begin(), mask->words().end(), out.words().begin());
  const auto copied = HostClock::now();
  facts.making = made - start;
  facts.copying = copied - made;
  const std::uint32_t steps =
      foot_of(plan_).steps(layer, static_cast<double>(grid().pitch_x_mm), static_cast<double>(grid().pitch_y_mm));
  if (steps > 0) {
    erode(out, steps, rows_);
    facts.making += HostClock::now() - copied;
  } else if (greys != nullptr) {
    for (const GreyRun& run : source_->greys()) greys->add(run);
  }
  facts.hash = mask_hash(out, greys != nullptr ? greys->runs() : std::span<const GreyRun>());
  facts.pixels = ConstBitImage(out).count() * plan_.steps.of(layer).step;
  return facts;
}

}  // namespace plumbline::firmware
