#include "slicer/supports/obstacles.hpp"

#include <algorithm>
#include <bit>
#include <cmath>

#include "slicer/core/bit_spans.hpp"
#include "slicer/layers/layer_stream.hpp"
#include "slicer/supports/near.hpp"

namespace plumbline::inline slicer {
namespace {

constexpr const char* kStage = "supports";
constexpr std::uint16_t kNever = 0xFFFF;

struct Sizes {
  std::uint32_t columns, rows, layers;  ///< of a voxel
  std::uint32_t nx, ny, nz;
  std::size_t slab_words() const { return BitImage::words_needed(nx, ny); }
  std::size_t words() const { return slab_words() * nz; }
};

Sizes sizes_of(const PrintGrid& grid) {
  Sizes s{};
  for (double side = Obstacles::kVoxel_mm;; side *= 1.25) {
    const auto count = [&](float pitch) {
      return static_cast<std::uint32_t>(std::max(1.0, std::floor(side / static_cast<double>(pitch) + 0.5)));
    };
    s.columns = count(grid.pitch_x_mm);
    s.rows = count(grid.pitch_y_mm);
    s.layers = count(grid.layer_height_mm);
    s.nx = (grid.columns + s.columns - 1) / s.columns;
    s.ny = (grid.rows + s.rows - 1) / s.rows;
    s.nz = (grid.layers + s.layers - 1) / s.layers;
    if (s.words() * sizeof(std::uint64_t) <= Obstacles::kMostBytes) return s;
  }
}

}  // namespace

Expected<Obstacles> Obstacles::create(const RRep& rrep, Nanometres column_radius, Arena& arena) {
  const Sizes s = sizes_of(rrep.grid);
  Obstacles o;
  o.columns_ = s.columns;
  o.rows_ = s.rows;
  o.layers_ = s.layers;
  o.nx_ = s.nx;
  o.ny_ = s.ny;
  o.nz_ = s.nz;
  const PixelPitch pixel(rrep.grid);
  o.pitch_.x = pixel.x * s.columns;
  o.pitch_.y = pixel.y * s.rows;
  o.slab_words_ = s.slab_words();
  PLUMBLINE_TRY(o.take_memory(arena));

  const std::size_t mark = arena.bottom_mark();
  auto stream = LayerStream::create(rrep, arena);
  PLUMBLINE_TRY(stream);
  const Window window = window_of(rrep);
  for (std::uint32_t k = 0; k < rrep.grid.layers; ++k) o.add(k, stream->mask(k), window);
  arena.release_bottom(mark);

  PLUMBLINE_TRY(o.find_lowest(column_radius, arena));
  return o;
}

Status Obstacles::take_memory(Arena& arena) {
  const auto words = arena.take_top<std::uint64_t>(slab_words_ * nz_, kStage);
  PLUMBLINE_TRY(words);
  words_ = *words;
  std::fill(words_.begin(), words_.end(), 0);
  const auto lowest = arena.take_top<std::uint16_t>(std::size_t{nx_} * ny_, kStage);
  PLUMBLINE_TRY(lowest);
  lowest_ = *lowest;
  std::fill(lowest_.begin(), lowest_.end(), kNever);
  return {};
}

/// Slab after slab, from the plate up: only columns of voxels that become solid for the first time can be the lowest ones near.
Status Obstacles::find_lowest(Nanometres column_radius, Arena& arena) {
  const ArenaScope scope(arena);
  const auto disc = Disc::create(pitch_, column_radius, arena);
  PLUMBLINE_TRY(disc);
  BitImage solid;  // columns that have a solid voxel below
  BitImage near;   // those that have one of these within the radius
  for (BitImage* image : {&solid, &near}) {
    const auto words = arena.take_top<std::uint64_t>(slab_words_, kStage);
    PLUMBLINE_TRY(words);
    *image = BitImage(*words, nx_, ny_);
    image->clear();
  }
  const auto fresh = arena.take_top<std::uint64_t>(solid.stride(), kStage);
  PLUMBLINE_TRY(fresh);
  for (std::uint32_t z = 0; z < nz_; ++z) {
    const BitImage here = slab(z);
    for (std::uint32_t y = 0; y < ny_; ++y) {
      const auto line = here.row(y);
      const auto before = solid.row(y);
      std::uint64_t any = 0;
      for (std::uint32_t w = 0; w < line.size(); ++w) {
        (*fresh)[w] = line[w] & ~before[w];
        any |= (*fresh)[w];
      }
      if (any == 0) continue;
      for (std::uint32_t w = 0; w < line.size(); ++w) before[w] |= line[w];
      disc->draw_near(*fresh, y, near, [&](std::uint32_t row, std::uint32_t w, std::uint64_t bits) {
        for (; bits != 0; bits &= bits - 1) {
          lowest_[std::size_t{row} * nx_ + w * 64 + static_cast<std::uint32_t>(std::countr_zero(bits))] =
              static_cast<std::uint16_t>(z);
        }
      });
    }
  }
  return {};
}

std::size_t Obstacles::bytes_needed(const PrintGrid& grid, double lift_mm) {
  const Sizes s = sizes_of(grid);
  constexpr std::size_t kDisc = 1024;  // rows of voxels in the largest radius, 15 mm, with a margin
  // A lifted object has more layers; its voxels may then be larger, but take no more than kMostBytes.
  const auto lifted = static_cast<std::size_t>(lift_mm / (s.layers * static_cast<double>(grid.layer_height_mm))) + 2;
  const std::size_t words = s.slab_words() * (s.nz + lifted) * sizeof(std::uint64_t);
  // Larger voxels are fewer, so the images of find_lowest() are no larger for a lifted object.
  const std::size_t images = 2 * Arena::rounded(s.slab_words() * sizeof(std::uint64_t)) +
                             Arena::rounded(BitImage::words_needed(s.nx, 1) * sizeof(std::uint64_t));
  return Arena::rounded(std::min(kMostBytes, words)) +
         Arena::rounded(std::size_t{s.nx} * s.ny * sizeof(std::uint16_t)) + images + kDisc;
}

void Obstacles::add(std::uint32_t layer, ConstBitImage mask, const Window& window) {
  const BitImage to = slab(layer / layers_);
  for (std::uint32_t y = window.row / rows_; y * rows_ < window.row_end; ++y) {
    const std::uint32_t row_end = std::min(window.row_end, (y + 1) * rows_);
    const auto line = to.row(y);
    for (std::uint32_t w = window.word; w < window.word_end; ++w) {
      std::uint64_t rest = 0;
      for (std::uint32_t r = std::max(window.row, y * rows_); r < row_end; ++r) rest |= mask.row(r)[w];
      while (rest != 0) {
        const auto first = static_cast<std::uint32_t>(std::countr_zero(rest));
        const auto length = static_cast<std::uint32_t>(std::countr_one(rest >> first));
        const std::uint32_t begin = (w * 64 + first) / columns_;
        const std::uint32_t end = (w * 64 + first + length - 1) / columns_ + 1;
        for_each_word(begin, end, [&](std::uint32_t word, std::uint64_t bits) { line[word] |= bits; });
        rest = first + length >= 64 ? 0 : rest & (~std::uint64_t{0} << (first + length));
      }
    }
  }
}

bool Obstacles::is_clear(std::int64_t column, std::int64_t row, std::int64_t layer, Nanometres radius) const {
  if (layer < 0 || column < 0 || row < 0) return layer < 0;
  const auto z = static_cast<std::uint32_t>(layer) / layers_;
  const auto x = static_cast<std::uint32_t>(column) / columns_;
  const auto y = static_cast<std::uint32_t>(row) / rows_;
  if (z >= nz_ || x >= nx_ || y >= ny_) return true;
  const ConstBitImage image = slab(z);
  bool clear = true;
  for_each_disc_span(pitch_, x, y, radius, nx_, ny_, [&](std::uint32_t r, std::uint32_t begin, std::uint32_t end) {
    if (!clear) return;
    const auto line = image.row(r);
    for_each_word(begin, end, [&](std::uint32_t w, std::uint64_t bits) { clear &= (line[w] & bits) == 0; });
  });
  return clear;
}

bool Obstacles::is_column_clear(std::int64_t column, std::int64_t row, std::int64_t layer) const {
  const auto x = static_cast<std::uint32_t>(column) / columns_;
  const auto y = static_cast<std::uint32_t>(row) / rows_;
  if (column < 0 || row < 0 || x >= nx_ || y >= ny_) return false;
  return layer < 0 || lowest_[std::size_t{y} * nx_ + x] > static_cast<std::uint32_t>(layer) / layers_;
}

std::uint32_t Obstacles::floor_below(std::uint32_t column, std::uint32_t row, std::uint32_t layer) const {
  std::uint32_t z = std::min(layer / layers_, nz_);
  while (z > 0 && !slab(z - 1).at(column / columns_, row / rows_)) --z;
  return z * layers_;
}

bool Obstacles::is_footing(std::uint32_t column, std::uint32_t row, std::uint32_t floor) const {
  const std::uint32_t x = column / columns_;
  const std::uint32_t y = row / rows_;
  const std::uint32_t z = floor / layers_;
  if (z == 0 || x == 0 || y == 0 || x + 1 >= nx_ || y + 1 >= ny_) return false;
  const ConstBitImage below = slab(z - 1);
  const ConstBitImage lower = slab(z - std::min(z, 2U));
  for (std::uint32_t r = y - 1; r <= y + 1; ++r) {
    for (std::uint32_t c = x - 1; c <= x + 1; ++c) {
      if (!below.at(c, r) && !lower.at(c, r)) return false;
    }
  }
  return true;
}

Vec3d Obstacles::normal(std::uint32_t column, std::uint32_t row, std::uint32_t layer, std::int32_t radius) const {
  const auto x = static_cast<std::int32_t>(column / columns_);
  const auto y = static_cast<std::int32_t>(row / rows_);
  const auto z = static_cast<std::int32_t>(layer / layers_);
  std::int64_t sum[3] = {0, 0, 0};
  for (std::int32_t dz = -radius; dz <= radius; ++dz) {
    if (z + dz < 0 || z + dz >= static_cast<std::int32_t>(nz_)) continue;
    const ConstBitImage image = slab(static_cast<std::uint32_t>(z + dz));
    for (std::int32_t dy = -radius; dy <= radius; ++dy) {
      const std::int32_t r = y + dy;
      const std::int32_t rest = radius * radius - dy * dy - dz * dz;
      if (rest < 0 || r < 0 || r >= static_cast<std::int32_t>(ny_)) continue;
      std::int32_t reach = radius;
      while (reach * reach > rest) --reach;
      const auto line = image.row(static_cast<std::uint32_t>(r));
      const auto begin = static_cast<std::uint32_t>(std::max(x - reach, 0));
      const auto end = static_cast<std::uint32_t>(std::min(x + reach + 1, static_cast<std::int32_t>(nx_)));
      if (begin >= end) continue;
      for_each_word(begin, end, [&](std::uint32_t w, std::uint64_t bits) {
        for (std::uint64_t solid = line[w] & bits; solid != 0; solid &= solid - 1) {
          sum[0] -= static_cast<std::int32_t>(w * 64) + std::countr_zero(solid) - x;
          sum[1] -= dy;
          sum[2] -= dz;
        }
      });
    }
  }
  const Vec3d n(static_cast<double>(sum[0]), static_cast<double>(sum[1]), static_cast<double>(sum[2]));
  const double length = std::sqrt(n[0] * n[0] + n[1] * n[1] + n[2] * n[2]);
  if (!(length > 0)) return {0, 0, -1};
  return {n[0] / length, n[1] / length, n[2] / length};
}

}  // namespace plumbline::inline slicer
