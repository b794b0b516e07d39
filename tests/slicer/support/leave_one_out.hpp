#pragma once
/// Compares each view of a real scan with a print made without that view, if the scan is present beside the repository.

#include <gtest/gtest.h>

#include <Eigen/Eigenvalues>
#include <algorithm>
#include <cmath>
#include <cstring>
#include <deque>
#include <filesystem>
#include <optional>
#include <regex>
#include <string>
#include <vector>

#include "tests/slicer/support/shared_scan.hpp"
#include "tests/slicer/support/slicing.hpp"

namespace plumbline::leave_one_out {

using namespace testing;

constexpr float kPitch = 0.2F;       ///< mm
constexpr std::size_t kEvery = 5;    ///< step between compared points of the omitted view
constexpr float kPlaneReach = 1.2F;  ///< mm: points of another view this near define its plane
constexpr std::size_t kPlanePoints = 6;
constexpr float kBeside = 0.6F;  ///< mm: their mean is at most this far away along the surface
constexpr float kFacing = 0.5F;  ///< least inner product of normals of the same side

/// The views of a scan, one surface each.
inline std::vector<Surface> views_of(const std::string& name) {
  const std::string bytes = content_of(shared_scan(name + ".ply"));
  const std::string counts = content_of(shared_scan(name + ".views.json"));
  constexpr std::size_t kPoint = 6 * sizeof(float);
  const std::string last_line = "end_header\n";
  std::size_t at = bytes.find(last_line) + last_line.size();
  const std::regex points("\"points\":\\s*([0-9]+)");
  std::vector<Surface> views;
  for (std::sregex_iterator m(counts.begin(), counts.end(), points); m != std::sregex_iterator(); ++m) {
    Surface& view = views.emplace_back(std::stoul((*m)[1]));
    for (SurfacePoint& p : view) {
      float values[6];
      std::memcpy(values, bytes.data() + at, kPoint);
      p = {Vec3d(values[0], values[1], values[2]), Vec3d(values[3], values[4], values[5])};
      at += kPoint;
    }
  }
  EXPECT_EQ(at, bytes.size()) << "the views are not the whole scan";
  return views;
}

/// A stack of sections that measures how far a place is from the surface of its voxels.
class Print {
 public:
  explicit Print(const Slicing& sliced) : grid_(sliced.grid()) {
    for (std::uint32_t k = 0; k < grid_.layers; ++k) layers_.emplace_back(grid_.columns, grid_.rows);
    sliced.for_each_section([&](std::uint32_t k, ConstBitImage section) {
      std::copy(section.words().begin(), section.words().end(), layers_[k].view().words().begin());
    });
  }

  /// @param at     in voxels
  /// @param reach  voxels
  /// @returns voxels; none if the surface is farther than `reach`
  std::optional<double> distance(const Vec3d& at, int reach) const {
    for (int r = 2; r <= reach; r *= 2) {
      const double found = nearest_face(at, r);
      if (found <= r - 1) return found;
    }
    return std::nullopt;
  }

 private:
  bool solid(int c, int r, int k) const {
    return c >= 0 && r >= 0 && k >= 0 && c < static_cast<int>(grid_.columns) && r < static_cast<int>(grid_.rows) &&
           k < static_cast<int>(grid_.layers) &&
           layers_[static_cast<std::size_t>(k)].view().at(static_cast<std::uint32_t>(c), static_cast<std::uint32_t>(r));
  }
  double nearest_face(const Vec3d& at, int reach) const {
    const Eigen::Vector3i from = at.array().floor().cast<int>().matrix();
    double least = 1e9;
    for (int k = from[2] - reach; k <= from[2] + reach; ++k) {
      for (int r = from[1] - reach; r <= from[1] + reach; ++r) {
        for (int c = from[0] - reach; c <= from[0] + reach; ++c) {
          const bool here = solid(c, r, k);
          for (int axis = 0; axis < 3; ++axis) {
            if (here == solid(c + (axis == 0 ? 1 : 0), r + (axis == 1 ? 1 : 0), k + (axis == 2 ? 1 : 0))) continue;
            Vec3d d = (at - Vec3d(c + 0.5, r + 0.5, k + 0.5)).cwiseAbs();
            const double across = std::abs(at[axis] - (Vec3d(c, r, k)[axis] + 1));
            for (int other = 0; other < 3; ++other) d[other] = other == axis ? across : std::max(0.0, d[other] - 0.5);
            least = std::min(least, d.norm());
          }
        }
      }
    }
    return least;
  }
  PrintGrid grid_;
  std::vector<OwnedImage> layers_;
};

/// One view that measures how far a place is from its surface.
class View {
 public:
  explicit View(const Surface& surface) : block_(8 * kMiB), cloud_(cloud_of(surface, *block_)) {
    tree_ = sort_by_tree(cloud_, *block_);
  }
  std::optional<double> distance(const SurfacePoint& place) const {
    const Vec3f at = place.position.cast<float>();
    const Vec3f normal = place.normal.cast<float>();
    std::vector<Vec3f> near;
    Vec3f facing = Vec3f::Zero();
    const Vec3f reach = Vec3f::Constant(kPlaneReach);
    tree_.visit_box(at - reach, at + reach, [&](std::uint32_t first, std::uint32_t last) {
      for (std::uint32_t i = first; i < last; ++i) {
        const Vec3f n = cloud_.normal[i].unpack();
        if ((cloud_.position[i] - at).norm() > kPlaneReach || n.dot(normal) < kFacing) continue;
        near.push_back(cloud_.position[i] - at);
        facing += n;
      }
    });
    if (near.size() < kPlanePoints) return std::nullopt;
    Vec3f mean = Vec3f::Zero();
    for (const Vec3f& p : near) mean += p / static_cast<float>(near.size());
    facing.normalize();
    if ((mean - facing * facing.dot(mean)).norm() > kBeside) return std::nullopt;
    Mat3d scatter = Mat3d::Zero();
    for (const Vec3f& p : near) scatter += (p - mean).cast<double>() * (p - mean).cast<double>().transpose();
    const Vec3d across = Eigen::SelfAdjointEigenSolver<Mat3d>(scatter).eigenvectors().col(0);
    return std::abs(across.dot(mean.cast<double>()));
  }

 private:
  ArenaBlock block_;
  Cloud cloud_;
  KdTree3 tree_;
};

inline double percentile_95(std::vector<double>& values) {
  const auto at = values.begin() + static_cast<std::ptrdiff_t>(values.size() * 95 / 100);
  std::nth_element(values.begin(), at, values.end());
  return *at;
}

/// For each view, at places that another view saw too: a print of the other views is at most 1.3 times as far from the
/// view's points as the views are from each other. Compares 95th percentiles.
/// @param only  the view to omit; all of them, one after the other, if none is given
inline void expect_prints_between_the_views(const std::string& name, std::optional<std::size_t> only = std::nullopt) {
  if (!std::filesystem::exists(shared_scan(name + ".views.json"))) {
    GTEST_SKIP() << "needs " << shared_scan(name + ".ply") << ", which is not part of the repository";
  }
  const std::vector<Surface> views = views_of(name);
  ASSERT_GE(views.size(), 3U);
  std::deque<View> trees;
  for (const Surface& view : views) trees.emplace_back(view);
  double worst = 0;
  for (std::size_t left_out = 0; left_out < views.size(); ++left_out) {
    if (only && left_out != *only) continue;
    Surface others;
    for (std::size_t v = 0; v < views.size(); ++v) {
      if (v != left_out) append(others, views[v]);
    }
    SliceSettings settings = settings_with_pitch(kPitch);
    settings.threads = 2;
    const Slicing sliced(binary_ply(others), settings, 256 * kMiB);
    const Print print(sliced);
    const Placement& placed = sliced.report().placement;
    std::vector<double> to_print;
    std::vector<double> between_views;
    for (std::size_t i = 0; i < views[left_out].size(); i += kEvery) {
      const SurfacePoint& place = views[left_out][i];
      bool seen = false;
      for (std::size_t v = 0; v < views.size(); ++v) {
        if (v == left_out) continue;
        const auto apart = trees[v].distance(place);
        if (!apart) continue;
        between_views.push_back(*apart);
        seen = true;
      }
      if (!seen) continue;
      const Vec3d at = (placed.rotation * place.position * placed.scale + placed.shift) / static_cast<double>(kPitch);
      constexpr int kReach = 32;
      to_print.push_back(static_cast<double>(kPitch) * print.distance(at, kReach).value_or(kReach));
    }
    ASSERT_GT(to_print.size(), 500U) << "view " << left_out << " has hardly a place that others saw";
    const double print_95 = percentile_95(to_print);
    const double views_95 = percentile_95(between_views);
    worst = std::max(worst, print_95 / views_95);
    EXPECT_LT(print_95, 1.3 * views_95) << "mm; without view " << left_out;
  }
  ::testing::Test::RecordProperty("worst_ratio_percent", static_cast<int>(std::lround(100 * worst)));
}

}  // namespace plumbline::leave_one_out
