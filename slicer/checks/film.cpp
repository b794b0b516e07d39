#include "slicer/checks/film.hpp"

namespace plumbline::inline slicer {

Expected<Film> Film::create(const PrintGrid& grid, Arena& arena) {
  Film film;
  for (BitImage* image : {&film.film_, &film.stayed_}) {
    const auto words = arena.take_top<std::uint64_t>(BitImage::words_needed(grid.columns, grid.rows), "checks");
    PLUMBLINE_TRY(words);
    *image = BitImage(*words, grid.columns, grid.rows);
    image->clear();
  }
  return film;
}

std::size_t Film::bytes_needed(const PrintGrid& grid) {
  return 2 * Arena::rounded(BitImage::words_needed(grid.columns, grid.rows) * sizeof(std::uint64_t));
}

void Film::shade(ConstBitImage mask, BitImage lit) const {
  for (std::size_t w = 0; w < mask.words().size(); ++w) lit.words()[w] = mask.words()[w] & ~film_.words()[w];
}

bool Film::touches_part(std::uint32_t row, const LayerRegions::Run& run) const {
  bool touches = false;
  for_each_word(run.first, run.last + 1U,
                [&](std::uint32_t w, std::uint64_t bits) { touches = touches || (stayed_.row(row)[w] & bits) != 0; });
  return touches;
}

void Film::keep(ConstBitImage mask) { shade(mask, stayed_); }

}  // namespace plumbline::inline slicer
