#include "firmware/pictures/side_pictures.hpp"

#include <algorithm>
#include <bit>
#include <cmath>
#include <numbers>
#include <utility>

#include "firmware/pictures/preview/preview_layout.hpp"
#include "firmware/pictures/preview/preview_page.hpp"
#include "firmware/pictures/preview/preview_section.hpp"
#include "firmware/pictures/preview/preview_shading.hpp"
#include "firmware/pictures/preview/preview_smoothing.hpp"

namespace plumbline::firmware::inline pictures {

using namespace preview;

namespace {

constexpr const char* kStage = "side pictures";
constexpr std::uint32_t kColumns = SidePicture::kMostColumns * kSamplesPerPixel;
constexpr std::uint32_t kRows = SidePicture::kMostRows * kSamplesPerPixel;
constexpr double kFree = 8;       ///< samples that stay free round the print
constexpr double kMostVoxel = 8;  ///< samples that a side of a voxel has at most
constexpr double kElevation = 20 * std::numbers::pi / 180;
constexpr std::size_t kSamplesOfASide = std::size_t{kColumns} * kRows;

/// What a cell of a coarse layer holds.
enum class Cell : std::uint8_t { kEmpty, kObject, kSupport };

/// Sides of a cell that have no other one next to them, as bits. Nobody looks from below.
enum CellFace : std::uint8_t { kRight = 1, kLeft = 2, kBack = 4, kFront = 8, kTop = 16 };

/// Half-open range of cells.
struct Cells {
  std::uint32_t begin = 0, end = 0;
};

/// The print in cubes whose sides are one sample of the pictures, layer by layer from below.
class CoarseLayers {
 public:
  CoarseLayers(const RRep& rrep, const Supports& supports, const Extent& extent, double samples_per_mm)
      : rrep_(rrep),
        supports_(supports),
        extent_(extent),
        column_size_(double{rrep.grid.pitch_x_mm} * samples_per_mm),
        row_size_(double{rrep.grid.pitch_y_mm} * samples_per_mm),
        layer_size_(double{rrep.grid.layer_height_mm} * samples_per_mm),
        width_(count(extent.column_end - extent.column, column_size_)),
        depth_(count(extent.row_end - extent.row, row_size_)),
        height_(count(extent.layer_end - extent.layer, layer_size_)) {}

  std::uint32_t width() const { return width_; }
  std::uint32_t depth() const { return depth_; }
  std::uint32_t height() const { return height_; }
  std::size_t cells() const { return std::size_t{width_} * depth_; }
  /// The largest side of a voxel, samples.
  float voxel() const { return static_cast<float>(std::max({1.0, column_size_, row_size_, layer_size_})); }

  /// Calls visit(x, y, z, cell, faces) for each cell that somebody beside or above the print can see.
  /// @param words      scratch: an image of the grid
  /// @param now, next  scratch: cells() each
  template <class Visit>
  void for_each_surface_cell(std::span<std::uint64_t> words, std::span<Cell> now, std::span<Cell> next, Visit visit) {
    Section section(rrep_, words);
    std::uint32_t done = 0;  // layers of the section
    const auto fill = [&](std::uint32_t z, std::span<Cell> cells) {
      std::fill(cells.begin(), cells.end(), Cell::kEmpty);
      if (z >= height_) return;
      const auto above = static_cast<std::uint32_t>((z + 0.5) / layer_size_);
      const std::uint32_t layer = std::min(extent_.layer + above, extent_.layer_end - 1);
      for (; done <= std::min(layer, rrep_.grid.layers - 1); ++done) {
        section.advance(done, [](std::uint32_t, std::uint32_t, bool) {});
      }
      if (layer < rrep_.grid.layers) fill_object(section.image(), cells);
      fill_supports(layer, cells);
    };
    fill(0, now);
    for (std::uint32_t z = 0; z < height_; ++z, std::swap(now, next)) {
      fill(z + 1, next);
      for (std::uint32_t y = 0; y < depth_; ++y) {
        const std::size_t line = std::size_t{y} * width_;
        for (std::uint32_t x = 0; x < width_; ++x) {
          const std::size_t at = line + x;
          if (now[at] == Cell::kEmpty) continue;
          unsigned faces = next[at] == Cell::kEmpty ? kTop : 0;
          if (x + 1 == width_ || now[at + 1] == Cell::kEmpty) faces |= kRight;
          if (x == 0 || now[at - 1] == Cell::kEmpty) faces |= kLeft;
          if (y + 1 == depth_ || now[at + width_] == Cell::kEmpty) faces |= kBack;
          if (y == 0 || now[at - width_] == Cell::kEmpty) faces |= kFront;
          if (faces != 0) visit(x, y, z, now[at], faces);
        }
      }
    }
  }

 private:
  static std::uint32_t count(std::uint32_t voxels, double size) {
    return std::max(1U, static_cast<std::uint32_t>(std::ceil(voxels * size)));
  }
  /// The cells of pixels [begin, end). Neighbours leave no gap; pixels smaller than a cell are in the one of their middle.
  static Cells cells_of(std::uint32_t begin, std::uint32_t end, double size, std::uint32_t count) {
    const double first = size < 1 ? (begin + 0.5) * size : begin * size;
    const double last = size < 1 ? (end - 0.5) * size + 1 : end * size;
    const auto from = std::min(static_cast<std::uint32_t>(first), count - 1);
    return {from, std::clamp(static_cast<std::uint32_t>(last), from + 1, count)};
  }

  /// Marks pixels [begin, end) of a row.
  void mark(std::span<Cell> cells, std::uint32_t row, std::uint32_t begin, std::uint32_t end, Cell cell) const {
    const Cells across = cells_of(begin - extent_.column, end - extent_.column, column_size_, width_);
    const Cells back = cells_of(row - extent_.row, row + 1 - extent_.row, row_size_, depth_);
    for (std::uint32_t y = back.begin; y < back.end; ++y) {
      for (std::uint32_t x = across.begin; x < across.end; ++x) {
        Cell& here = cells[std::size_t{y} * width_ + x];
        if (here == Cell::kEmpty) here = cell;
      }
    }
  }
  void fill_object(const BitImage& image, std::span<Cell> cells) const {
    for (std::uint32_t row = extent_.row; row < extent_.row_end; ++row) {
      const auto words = image.row(row);
      for (std::uint32_t w = extent_.column / 64; w <= (extent_.column_end - 1) / 64; ++w) {
        std::uint64_t rest = words[w];
        while (rest != 0) {
          const auto begin = static_cast<std::uint32_t>(std::countr_zero(rest));
          const auto length = static_cast<std::uint32_t>(std::countr_one(rest >> begin));
          mark(cells, row, 64 * w + begin, 64 * w + begin + length, Cell::kObject);
          if (begin + length == 64) break;
          rest &= ~std::uint64_t{0} << (begin + length);
        }
      }
    }
  }
  void fill_supports(std::uint32_t layer, std::span<Cell> cells) const {
    for (const Strut& strut : supports_.list) {
      if (!strut.is_in(layer)) continue;
      for_each_span(supports_, strut, layer, rrep_.grid,
                    [&](std::uint32_t row, std::uint32_t begin, std::uint32_t end) {
                      if (begin < end) mark(cells, row, begin, end, Cell::kSupport);
                    });
    }
  }

  const RRep& rrep_;
  const Supports& supports_;
  const Extent& extent_;
  double column_size_, row_size_, layer_size_;  ///< of a voxel, samples
  std::uint32_t width_, depth_, height_;        ///< cells
};

/// A parallel projection onto a side's picture.
class View {
 public:
  View(std::size_t side, const CoarseLayers& print, const DepthMap& map)
      : map_(map), middle_(vector(print.width() / 2.0, print.depth() / 2.0, print.height() / 2.0)) {
    const double turn = 2 * std::numbers::pi * static_cast<double>(side) / kSideCount;
    const double c = std::cos(turn), s = std::sin(turn), ce = std::cos(kElevation), se = std::sin(kElevation);
    right_ = vector(c, s, 0);
    away_ = vector(-s * ce, c * ce, -se);
    up_ = vector(-s * se, c * se, ce);
    if (away_[0] < kAcross) seen_ |= kRight;
    if (away_[0] > -kAcross) seen_ |= kLeft;
    if (away_[1] < kAcross) seen_ |= kBack;
    if (away_[1] > -kAcross) seen_ |= kFront;
  }

  /// Shows a cell where nothing nearer is shown.
  /// @param faces  those that are free
  void show(std::uint32_t x, std::uint32_t y, std::uint32_t z, bool is_support, unsigned faces) const {
    if ((faces & seen_) == 0) return;
    const Vector place{static_cast<float>(x) + 0.5F - middle_[0], static_cast<float>(y) + 0.5F - middle_[1],
                       static_cast<float>(z) + 0.5F - middle_[2]};
    // A cube covers 1.4 x 1.4 samples at most, and its neighbour's middle is no farther away: 2 x 2 leave no hole.
    const auto column = static_cast<std::int32_t>(kColumns / 2.0F - 0.5F + dot(right_, place));
    const auto row = static_cast<std::int32_t>(kRows / 2.0F - 0.5F - dot(up_, place));
    if (column < 0 || row < 0) return;
    const float depth = dot(away_, place);
    for (std::uint32_t k = 0; k < 4; ++k) {
      const std::uint32_t u = static_cast<std::uint32_t>(column) + k % 2, v = static_cast<std::uint32_t>(row) + k / 2;
      if (u < kColumns && v < kRows && depth < map_.at(u, v)) map_.show(u, v, depth, is_support);
    }
  }

 private:
  using Vector = std::array<float, 3>;
  static constexpr float kAcross = 1e-6F;  ///< a face along the view counts as seen
  static Vector vector(double x, double y, double z) {
    return {static_cast<float>(x), static_cast<float>(y), static_cast<float>(z)};
  }
  static float dot(const Vector& a, const Vector& b) { return a[0] * b[0] + a[1] * b[1] + a[2] * b[2]; }

  DepthMap map_;
  Vector middle_, right_{}, away_{}, up_{};
  unsigned seen_ = kTop;  ///< faces that are turned to the viewer
};

/// The largest scale at which the print fits each picture, samples a mm.
double scale_of(const Extent& extent, const PrintGrid& grid) {
  const double width = (extent.column_end - extent.column) * double{grid.pitch_x_mm};
  const double depth = (extent.row_end - extent.row) * double{grid.pitch_y_mm};
  const double height = (extent.layer_end - extent.layer) * double{grid.layer_height_mm};
  const double voxel = std::max({grid.pitch_x_mm, grid.pitch_y_mm, grid.layer_height_mm});
  const double across = std::sqrt(width * width + depth * depth);
  const double tall = height * std::cos(kElevation) + across * std::sin(kElevation);
  return std::min({(kColumns - 2 * kFree) / across, (kRows - 2 * kFree) / tall, kMostVoxel / voxel});
}

}  // namespace

std::size_t side_pictures_bytes(const PrintGrid& grid) {
  // The print's diagonal fits a picture, and so does each side of a layer.
  constexpr std::size_t kMostCells = std::size_t{kColumns} * kColumns;
  return Arena::rounded(BitImage::words_needed(grid.columns, grid.rows) * sizeof(std::uint64_t)) +
         Arena::rounded(2 * kMostCells * sizeof(Cell)) + Arena::rounded(kSideCount * kSamplesOfASide * sizeof(float)) +
         Arena::rounded(kSideCount * kSamplesOfASide) + Arena::rounded(kSamplesOfASide * sizeof(float));
}

Status draw_side_pictures(const RRep& rrep, const Supports& supports, Arena& arena, SidePictures& pictures) {
  for (SidePicture& picture : pictures) picture.clear();
  const PrintGrid& grid = rrep.grid;
  const ArenaScope scope(arena);
  const auto words = arena.take_top<std::uint64_t>(BitImage::words_needed(grid.columns, grid.rows), kStage);
  PLUMBLINE_TRY(words);
  const Extent object = find_extent(rrep, *words);
  if (object.empty()) return {};
  const Extent extent = with_supports(object, supports, grid);
  CoarseLayers print(rrep, supports, extent, scale_of(extent, grid));
  const auto layers = arena.take_top<Cell>(2 * print.cells(), kStage);
  PLUMBLINE_TRY(layers);
  const auto depths = arena.take_top<float>(kSideCount * kSamplesOfASide, kStage);
  PLUMBLINE_TRY(depths);
  const auto materials = arena.take_top<std::uint8_t>(kSideCount * kSamplesOfASide, kStage);
  PLUMBLINE_TRY(materials);
  const auto scratch = arena.take_top<float>(kSamplesOfASide, kStage);
  PLUMBLINE_TRY(scratch);

  std::fill(depths->begin(), depths->end(), DepthMap::kEmpty);
  std::array<DepthMap, kSideCount> maps;
  for (std::size_t i = 0; i < kSideCount; ++i) {
    maps[i] = {depths->subspan(i * kSamplesOfASide, kSamplesOfASide),
               materials->subspan(i * kSamplesOfASide, kSamplesOfASide), kColumns, kRows};
  }
  const auto views = [&]<std::size_t... Side>(std::index_sequence<Side...>) {
    return std::array{View(Side, print, maps[Side])...};
  }
  (std::make_index_sequence<kSideCount>());
  print.for_each_surface_cell(*words, layers->first(print.cells()), layers->last(print.cells()),
                              [&](std::uint32_t x, std::uint32_t y, std::uint32_t z, Cell cell, unsigned faces) {
                                for (const View& view : views) view.show(x, y, z, cell == Cell::kSupport, faces);
                              });
  for (std::size_t i = 0; i < kSideCount; ++i) {
    smooth_depth(maps[i], *scratch, {.across = print.voxel(), .deep = print.voxel()});
    SidePicture& picture = pictures[i];
    picture.columns = SidePicture::kMostColumns;
    picture.rows = SidePicture::kMostRows;
    const Picture page{picture.bytes(), picture.columns, picture.rows};
    draw_background(page);
    shade_depth(maps[i], *scratch, page, 0, 0, kMaterials);
    keep_five_bits(picture.bytes());
  }
  return {};
}

}  // namespace plumbline::firmware::inline pictures
