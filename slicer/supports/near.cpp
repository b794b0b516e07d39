#include "slicer/supports/near.hpp"

#include <algorithm>

namespace plumbline::inline slicer {
namespace {

/// White where a pixel of the word is at most `reach` away, within the word.
std::uint64_t spread(std::uint64_t word, std::uint32_t reach) {
  std::uint32_t rest = std::min(reach, 63U);
  for (std::uint32_t step = 1; rest > 0; step *= 2) {
    const std::uint32_t by = std::min(step, rest);
    word |= word << by | word >> by;
    rest -= by;
  }
  return word;
}

/// The lowest `count` bits.
std::uint64_t low_bits(std::uint32_t count) {
  return count >= 64 ? ~std::uint64_t{0} : (std::uint64_t{1} << count) - 1;
}

}  // namespace

std::uint64_t near_in_row(std::span<const std::uint64_t> row, std::uint32_t w, std::uint32_t reach) {
  std::uint64_t found = row[w] == 0 ? 0 : spread(row[w], reach);
  const std::uint32_t words = reach / 64 + (reach % 64 == 0 ? 0 : 1);
  for (std::uint32_t i = 1; i <= std::min(words, w); ++i) {  // the nearest before the word covers most of it
    if (row[w - i] == 0) continue;
    const std::uint32_t distance = (i - 1) * 64 + static_cast<std::uint32_t>(std::countl_zero(row[w - i])) + 1;
    if (distance <= reach) found |= low_bits(reach - distance + 1);
    break;
  }
  for (std::uint32_t i = 1; i <= words && w + i < row.size(); ++i) {
    if (row[w + i] == 0) continue;
    const std::uint32_t distance = (i - 1) * 64 + static_cast<std::uint32_t>(std::countr_zero(row[w + i])) + 1;
    if (distance <= reach) {
      const std::uint32_t covered = std::min(64U, reach - distance + 1);
      found |= low_bits(covered) << (64 - covered);
    }
    break;
  }
  return found;
}

Expected<Disc> Disc::create(const PixelPitch& pitch, Nanometres radius, Arena& arena) {
  auto reach = arena.take_top<std::uint32_t>(static_cast<std::size_t>(radius / pitch.y) + 1, "supports");
  PLUMBLINE_TRY(reach);
  for_each_disc_row(pitch, radius, [&](std::uint32_t dy, std::uint32_t columns) { (*reach)[dy] = columns; });
  Disc disc;
  disc.reach_ = *reach;
  return disc;
}

std::size_t Disc::bytes_needed(const PixelPitch& pitch, Nanometres radius) {
  return Arena::rounded((static_cast<std::size_t>(radius / pitch.y) + 1) * sizeof(std::uint32_t));
}

std::uint64_t Disc::near(ConstBitImage image, std::uint32_t row, std::uint32_t word, std::uint64_t wanted) const {
  std::uint64_t missing = wanted;
  for (std::uint32_t dy = 0; dy < reach_.size() && missing != 0; ++dy) {
    if (dy <= row) missing &= ~near_in_row(image.row(row - dy), word, reach_[dy]);
    if (dy > 0 && row + dy < image.rows()) missing &= ~near_in_row(image.row(row + dy), word, reach_[dy]);
  }
  return wanted & ~missing;
}

}  // namespace plumbline::inline slicer
