#include "slicer/rays/ray_grid.hpp"

#include <omp.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <limits>

namespace plumbline {
namespace {

constexpr float kSqrtPi = 1.77245385F;
constexpr float kSqrt2 = 1.41421356F;

/// Mean distance in the plane to the k-th nearest other point of the class, infinite where there is none.
double mean_distance(const Cloud& cloud, const KdTree2& tree, PointClass of, const RayGridSettings& settings) {
  std::uint32_t members = 0;
  for (std::uint32_t i = 0; i < cloud.size; ++i) members += cloud.normal[i].point_class == of ? 1 : 0;
  if (members <= settings.neighbour) return std::numeric_limits<double>::infinity();
  const std::uint32_t step = std::max<std::uint32_t>(1, members / settings.width_sample);
  std::array<Neighbour, 64> found;  // NOLINT(cppcoreguidelines-pro-type-member-init)
  const std::span<Neighbour> wanted = std::span(found).first(std::min<std::size_t>(64, settings.neighbour + 1));
  double sum = 0;
  std::uint32_t samples = 0;
  std::uint32_t member = 0;
  for (std::uint32_t i = 0; i < cloud.size; ++i) {
    if (cloud.normal[i].point_class != of || member++ % step != 0) continue;
    const std::uint32_t k =
        tree.nearest(cloud.position[i], wanted, [&](std::uint32_t j) { return cloud.normal[j].point_class == of; });
    sum += std::sqrt(static_cast<double>(found[k - 1].distance2));
    ++samples;
  }
  return sum / samples;
}

/// Sets bits [first, last) of a row.
void set_run(std::span<std::uint64_t> row, std::uint32_t first, std::uint32_t last) {
  for (std::uint32_t word = first / 64; word <= (last - 1) / 64; ++word) {
    std::uint64_t bits = ~std::uint64_t{0};
    if (word == first / 64) bits &= ~std::uint64_t{0} << (first % 64);
    if (word == (last - 1) / 64 && last % 64 != 0) bits &= (std::uint64_t{1} << (last % 64)) - 1;
    row[word] |= bits;
  }
}

bool any_in_run(std::span<const std::uint64_t> row, std::uint32_t first, std::uint32_t last) {
  for (std::uint32_t word = first / 64; word <= (last - 1) / 64; ++word) {
    std::uint64_t bits = row[word];
    if (word == first / 64) bits &= ~std::uint64_t{0} << (first % 64);
    if (word == (last - 1) / 64 && last % 64 != 0) bits &= (std::uint64_t{1} << (last % 64)) - 1;
    if (bits != 0) return true;
  }
  return false;
}

/// First column at or after `from` where the row has the wanted bit, `columns` if none.
std::uint32_t next_bit(std::span<const std::uint64_t> row, std::uint32_t from, std::uint32_t columns, bool wanted) {
  while (from < columns) {
    const std::uint64_t word = (wanted ? row[from / 64] : ~row[from / 64]) >> (from % 64);
    if (word != 0) return std::min(columns, from + static_cast<std::uint32_t>(std::countr_zero(word)));
    from = (from / 64 + 1) * 64;
  }
  return columns;
}

/// Grows `outside` from row `from` into row `to`, along whole runs of pixels that are not passing.
bool spread(ConstBitImage passing, BitImage outside, std::uint32_t from, std::uint32_t to) {
  bool changed = false;
  const auto passing_row = passing.row(to);
  const std::span<const std::uint64_t> source = outside.row(from);
  const std::span<std::uint64_t> target = outside.row(to);
  for (std::uint32_t column = 0; column < passing.columns();) {
    const std::uint32_t first = next_bit(passing_row, column, passing.columns(), false);
    if (first == passing.columns()) break;
    const std::uint32_t last = next_bit(passing_row, first, passing.columns(), true);
    const bool is_outside = (target[first / 64] >> (first % 64)) & 1U;  // a run is marked whole or not at all
    if (!is_outside && any_in_run(source, first, last)) {
      set_run(target, first, last);
      changed = true;
    }
    column = last;
  }
  return changed;
}

/// Sets the pixels whose centres are within the radius of a point: row by row, the chord of the point's disc.
/// @param share  only rows share, share + shares, share + 2 shares, ... are set: a thread's own
void mark_passing(const Cloud& cloud, const PrintGrid& grid, float radius, BitImage passing, std::uint32_t share,
                  std::uint32_t shares) {
  for (const Vec3f& p : cloud.positions()) {
    const float centre_row = p[1] / grid.pitch_y_mm - 0.5F;
    const float half_rows = radius / grid.pitch_y_mm;
    const float last_row = static_cast<float>(grid.rows - 1);
    if (centre_row + half_rows < 0 || centre_row - half_rows > last_row) continue;
    const auto low = static_cast<std::uint32_t>(std::ceil(std::max(0.0F, centre_row - half_rows)));
    const auto high = static_cast<std::uint32_t>(std::floor(std::min(last_row, centre_row + half_rows)));
    for (std::uint32_t r = low + (share + shares - low % shares) % shares; r <= high; r += shares) {
      const float dy = (static_cast<float>(r) - centre_row) * grid.pitch_y_mm;
      const float half = std::sqrt(std::max(0.0F, radius * radius - dy * dy)) / grid.pitch_x_mm;
      const float centre = p[0] / grid.pitch_x_mm - 0.5F;
      const float last_column = static_cast<float>(grid.columns - 1);
      if (centre + half < 0 || centre - half > last_column) continue;
      const auto first = static_cast<std::uint32_t>(std::ceil(std::max(0.0F, centre - half)));
      const auto last = static_cast<std::uint32_t>(std::floor(std::min(last_column, centre + half)));
      if (first <= last) set_run(passing.row(r), first, last + 1);
    }
  }
}

/// Fills what the passing pixels enclose: all that cannot be reached from the border of the image.
void fill_contours(BitImage passing, BitImage outside) {
  outside.clear();
  const std::uint32_t columns = passing.columns();
  const std::uint32_t rows = passing.rows();
  for (std::uint32_t r = 0; r < rows; ++r) {
    const auto row = passing.row(r);
    for (std::uint32_t column = 0; column < columns;) {
      const std::uint32_t first = next_bit(row, column, columns, false);
      if (first == columns) break;
      const std::uint32_t last = next_bit(row, first, columns, true);
      if (first == 0 || last == columns || r == 0 || r == rows - 1) set_run(outside.row(r), first, last);
      column = last;
    }
  }
  // Down and up until nothing changes: two sweeps for a convex outline, more for one that winds.
  for (bool changed = true; changed;) {
    changed = false;
    for (std::uint32_t r = 1; r < rows; ++r) changed |= spread(passing, outside, r - 1, r);
    for (std::uint32_t r = rows - 1; r > 0; --r) changed |= spread(passing, outside, r, r - 1);
  }
  for (std::uint32_t r = 0; r < rows; ++r) {
    auto inside = passing.row(r);
    const auto out = outside.row(r);
    for (std::uint32_t word = 0; word < passing.stride(); ++word) inside[word] = ~out[word];
    inside[passing.stride() - 1] &= passing.last_word_mask();
  }
}

}  // namespace

float grid_width(const Cloud& cloud, const KdTree2& tree, const RayGridSettings& settings) {
  constexpr std::array kClasses = {PointClass::kEntering, PointClass::kExiting};
  std::array<double, 2> distances = {};
#pragma omp parallel for schedule(static, 1)
  for (std::size_t i = 0; i < kClasses.size(); ++i) {
    distances[i] = mean_distance(cloud, tree, kClasses[i], settings);
  }
  const double least = std::min(distances[0], distances[1]);
  return std::isfinite(least) ? kSqrtPi * static_cast<float>(least) : 0.0F;
}

Status find_interested_rays(const Cloud& cloud, const PrintGrid& grid, float width, BitImage interested, Arena& arena) {
  const ArenaScope scope(arena);
  auto words = arena.take_top<std::uint64_t>(BitImage::words_needed(grid.columns, grid.rows), "ray grid");
  if (!words) return tl::unexpected<Error>(words.error());
  interested.clear();
#pragma omp parallel
  mark_passing(cloud, grid, kSqrt2 * width, interested, static_cast<std::uint32_t>(omp_get_thread_num()),
               static_cast<std::uint32_t>(omp_get_num_threads()));
  fill_contours(interested, BitImage(*words, grid.columns, grid.rows));
  return {};
}

}  // namespace plumbline
