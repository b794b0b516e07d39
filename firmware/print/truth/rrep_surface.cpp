#include "firmware/print/truth/rrep_surface.hpp"

#include <Eigen/Eigenvalues>
#include <algorithm>
#include <bit>
#include <cmath>
#include <optional>

#include "slicer/core/numbers/mix64.hpp"

namespace plumbline::firmware {
namespace {

/// Between a pixel of a layer and the one before it along an axis.
struct VoxelFace {
  int axis = 0;      ///< 0: x, 1: y, 2: z
  int outwards = 0;  ///< -1 or 1, along the axis
  std::int64_t column = 0, row = 0, layer = 0;
};

/// Some sections of an R-Rep in turn, each without what is black beside the object.
class Sections {
 public:
  static constexpr std::int64_t kReach = 4;  ///< pixels

  explicit Sections(const RRep& rrep) : rrep_(rrep) {
    std::int64_t first = rrep.grid.columns, last = -1;
    for (const std::uint32_t pixel : rrep.pixel) {
      first = std::min<std::int64_t>(first, pixel % rrep.grid.columns);
      last = std::max<std::int64_t>(last, pixel % rrep.grid.columns);
      row_ = std::min<std::int64_t>(row_, pixel / rrep.grid.columns);
      end_row_ = std::max<std::int64_t>(end_row_, pixel / rrep.grid.columns + 1);
    }
    column_ = first;
    end_column_ = last + 1;
    stride_ = (end_column_ - column_ + 63) / 64 + 1;
    const double pixels = kReach * static_cast<double>(std::max(rrep.grid.pitch_x_mm, rrep.grid.pitch_y_mm));
    reach_ = std::clamp<std::int64_t>(std::llround(pixels / static_cast<double>(rrep.grid.layer_height_mm)), 1, 32);
    sections_.resize(static_cast<std::size_t>(2 * reach_ + 2));
    for (auto& words : sections_) words.assign(static_cast<std::size_t>((end_row_ - row_) * stride_), 0);
  }

  std::int64_t reach() const { return reach_; }  ///< layers that are held before and after the current one

  /// Makes the next section: that of `layer` + reach().
  void advance(std::int64_t layer) {
    const std::int64_t next = layer + reach_;
    auto& words = section(next);
    words = section(next - 1);
    if (next >= rrep_.grid.layers) return std::fill(words.begin(), words.end(), 0);
    for (std::uint32_t k = rrep_.first[static_cast<std::size_t>(next)];
         k < rrep_.first[static_cast<std::size_t>(next) + 1]; ++k) {
      const std::int64_t column = rrep_.pixel[k] % rrep_.grid.columns - column_,
                         row = rrep_.pixel[k] / rrep_.grid.columns;
      words[static_cast<std::size_t>((row - row_) * stride_ + column / 64)] ^= std::uint64_t{1} << (column % 64);
    }
  }

  /// Calls visit(VoxelFace) for the faces of pixels in a layer that is held: columns, rows [low, end).
  /// @param sides  only those along x and y
  template <class Visit>
  void for_each_face(std::int64_t layer, std::int64_t low_column, std::int64_t end_column, std::int64_t low_row,
                     std::int64_t end_row, bool sides, Visit visit) const {
    for (std::int64_t row = std::max(low_row, row_); row < std::min(end_row, end_row_ + 1); ++row) {
      for (std::int64_t column = low_column; column < end_column; column += 64) {
        const std::int64_t count = std::min<std::int64_t>(64, end_column - column);
        const std::uint64_t valid = count == 64 ? ~std::uint64_t{0} : (std::uint64_t{1} << count) - 1;
        const std::uint64_t here = bits(layer, row, column);
        const std::uint64_t changed[] = {here ^ bits(layer, row, column - 1), here ^ bits(layer, row - 1, column),
                                         sides ? 0 : here ^ bits(layer - 1, row, column)};
        for (int axis = 0; axis < 3; ++axis) {
          for (std::uint64_t left = changed[axis] & valid; left != 0; left &= left - 1) {
            const int bit = std::countr_zero(left);
            visit(VoxelFace{axis, (here >> bit & 1U) != 0 ? -1 : 1, column + bit, row, layer});
          }
        }
      }
    }
  }
  /// All sides of a layer.
  template <class Visit>
  void for_each_side(std::int64_t layer, Visit visit) const {
    for_each_face(layer, column_, end_column_ + 1, row_, end_row_ + 1, true, visit);
  }

  /// All tops below a layer that is black.
  template <class Visit>
  void for_each_top(std::int64_t layer, Visit visit) const {
    for_each_face(layer, column_, end_column_, row_, end_row_, false, visit);
  }

  bool is_inside(std::int64_t layer, std::int64_t row, std::int64_t column) const {
    return (bits(layer, row, column) & 1U) != 0;
  }
  Vec3d middle(const VoxelFace& face) const {
    const auto at = [&face](std::int64_t i, int axis) {
      return static_cast<double>(i) + (face.axis == axis ? 0 : 0.5);
    };
    return {at(face.column, 0) * double{rrep_.grid.pitch_x_mm}, at(face.row, 1) * double{rrep_.grid.pitch_y_mm},
            at(face.layer, 2) * double{rrep_.grid.layer_height_mm}};
  }

 private:
  std::vector<std::uint64_t>& section(std::int64_t layer) {
    return sections_[static_cast<std::size_t>(layer + 2 * reach_ + 2) % sections_.size()];
  }
  /// 64 pixels from a column on.
  std::uint64_t bits(std::int64_t layer, std::int64_t row, std::int64_t column) const {
    if (row < row_ || row >= end_row_) return 0;
    const auto& words = sections_[static_cast<std::size_t>(layer + 2 * reach_ + 2) % sections_.size()];
    const std::int64_t from = column - column_, word = from >> 6;
    const auto shift = static_cast<unsigned>(from & 63);
    const auto at = [&](std::int64_t w) {
      return w < 0 || w >= stride_ ? 0 : words[static_cast<std::size_t>((row - row_) * stride_ + w)];
    };
    return shift == 0 ? at(word) : at(word) >> shift | at(word + 1) << (64 - shift);
  }

  const RRep& rrep_;
  std::int64_t column_ = 0, end_column_ = 0, row_ = PrintGrid::kMaxSide, end_row_ = 0, stride_ = 0, reach_ = 1;
  std::vector<std::vector<std::uint64_t>> sections_;
};

/// The plane through the faces near one; none at an edge.
std::optional<OrientedPoint> plane_at(const Sections& sections, const PrintGrid& grid, const VoxelFace& face) {
  constexpr std::int64_t kReach = Sections::kReach;
  const Vec3d pixel(double{grid.pitch_x_mm}, double{grid.pitch_y_mm}, double{grid.layer_height_mm});
  const Vec3d here = sections.middle(face);
  const double radius = kReach * std::max(pixel[0], pixel[1]);
  const auto for_each_near = [&](std::int64_t pixels, std::int64_t layers, auto visit) {
    for (std::int64_t k = face.layer - layers; k <= face.layer + layers; ++k) {
      sections.for_each_face(k, face.column - pixels, face.column + pixels + 1, face.row - pixels,
                             face.row + pixels + 1, false, visit);
    }
  };
  // The other side of a thin wall faces the other way.
  const Vec3d area(pixel[1] * pixel[2], pixel[2] * pixel[0], pixel[0] * pixel[1]);
  Vec3d facing = Vec3d::Zero();
  for_each_near(2, std::min<std::int64_t>(2, sections.reach()),
                [&](const VoxelFace& f) { facing[f.axis] += f.outwards * area[f.axis]; });
  double weight = 0;
  Vec3d sum = Vec3d::Zero();
  Mat3d squares = Mat3d::Zero();
  for_each_near(kReach, sections.reach(), [&](const VoxelFace& f) {
    const Vec3d off = sections.middle(f) - here;
    const double near = 1 - off.dot(off) / (radius * radius);
    if (near <= 0 || f.outwards * facing[f.axis] <= 0) return;
    const double w = near * near * area[f.axis];
    weight += w;
    sum += w * off;
    squares += w * off * off.transpose();
  });
  if (!(weight > 0)) return std::nullopt;
  const Vec3d mean = sum / weight;
  const Eigen::SelfAdjointEigenSolver<Mat3d> plane(squares / weight - mean * mean.transpose());
  const double tolerance = 0.45 * pixel.maxCoeff();
  if (plane.eigenvalues()[0] > tolerance * tolerance) return std::nullopt;
  Vec3d normal = plane.eigenvectors().col(0);
  if (normal.dot(facing) < 0) normal = -normal;
  return OrientedPoint{Vec3d(here + mean.dot(normal) * normal).cast<float>(), normal.cast<float>()};
}

bool chance(std::uint64_t number, double share) { return static_cast<double>(mix64(number)) < share * 0x1p64; }

}  // namespace

TrueSurface surface_samples(const RRep& rrep) {
  constexpr double kPoints = 15'000;  // fewer than of a mesh, since each takes longer
  constexpr std::int64_t kStep = 8;   // sides are taken from every eighth layer
  TrueSurface surface{.name = "r-rep", .points = {}};
  if (rrep.pixel.empty()) return surface;
  const PrintGrid& grid = rrep.grid;
  const std::int64_t layers = grid.layers;
  const double side_share = static_cast<double>(grid.layer_height_mm / std::max(grid.pitch_x_mm, grid.pitch_y_mm));
  double faces = static_cast<double>(rrep.pixel.size());
  {
    Sections sections(rrep);
    for (std::int64_t k = -sections.reach(); k < layers; ++k) {
      sections.advance(k);
      if (k < 0 || k % (2 * kStep) != 0) continue;
      sections.for_each_side(k, [&](const VoxelFace&) { faces += 2 * kStep * side_share; });
    }
  }
  // A surface has up to 1.7 times its area in faces; evenly spread over directions 1.5 times.
  const double share = 1.5 * kPoints / faces;
  Sections sections(rrep);
  const auto take = [&](const VoxelFace& face, double of) {
    const auto number = [](std::int64_t i) { return static_cast<std::uint64_t>(i); };
    const std::uint64_t name = ((number(face.layer) << 16U | number(face.row)) << 16U | number(face.column)) << 2U |
                               static_cast<std::uint64_t>(face.axis);
    if (!chance(name, of)) return;
    const auto point = plane_at(sections, grid, face);
    if (point && chance(~name, 1 / static_cast<double>(point->normal.cwiseAbs().sum())))
      surface.points.push_back(*point);
  };
  for (std::int64_t k = -sections.reach(); k <= layers; ++k) {
    sections.advance(k);
    if (k < 0) continue;
    if (k % kStep == 0)
      sections.for_each_side(k, [&](const VoxelFace& face) { take(face, kStep * side_share * share); });
    if (k == layers) {  // what continues to the top of the last layer ends there
      sections.for_each_top(k, [&](const VoxelFace& face) { take(face, share); });
      break;
    }
    const auto layer = static_cast<std::size_t>(k);
    for (std::uint32_t i = rrep.first[layer]; i < rrep.first[layer + 1]; ++i) {
      const std::int64_t row = rrep.pixel[i] / grid.columns, column = rrep.pixel[i] % grid.columns;
      take({2, sections.is_inside(k, row, column) ? -1 : 1, column, row, k}, share);
    }
  }
  return surface;
}

}  // namespace plumbline::firmware
