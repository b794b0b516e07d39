#include "slicer/placement/floor_plane.hpp"

#include <Eigen/LU>
#include <algorithm>
#include <array>
#include <cmath>
#include <cstddef>
#include <cstdint>

namespace plumbline::inline slicer {
namespace {

constexpr std::uint32_t kSample = 4096;  ///< points whose heights give the object's lowest and highest
constexpr float kLowPart = 0.4F;         ///< of the height, where the floor is looked for
constexpr float kUp = 0.9F;              ///< least n_z of a point of the floor: 26 degrees, for noisy normals
constexpr float kLevel = 0.9848F;        ///< cosine of 10 degrees
constexpr float kSameWay = 0.98F;        ///< cosine within which normals are averaged: 11 degrees
constexpr float kLeastPoints = 0.05F;    ///< of the scan, in the floor and in the object
constexpr float kMostBelow = 0.01F;      ///< of the floor's points; a plate of 1 mm has walls of a tenth
constexpr float kMarginEpsilons = 0.3F;  ///< supports reach as far, so the floor would bend the foot of the object
constexpr float kMarginNoise = 4;        ///< standard deviations
constexpr float kRound = 1.08F;  ///< radius over half of a side: of a disc 1.04, of an octagon 1.1, of a square 1.4
constexpr float kRim = 0.07F;    ///< of the radius: how near to the edge a turntable's wall is
constexpr float kMostInside = 0.05F;   ///< of the points below a turntable: not at its edge, as those of an underside
constexpr float kMostOnRim = 0.6F;     ///< the object's side over the turntable's; round plinths are rarely so wide
constexpr float kReach = 0.05F;        ///< of the object's side, by which the floor reaches beyond it
constexpr float kFree = 0.25F;         ///< share of the floor that has no object above it
constexpr float kLeastHeight = 0.25F;  ///< of the object's larger horizontal side
constexpr std::size_t kBins = 512;     ///< of the histogram of heights
constexpr std::uint32_t kSide = 32;    ///< cells of the map of the floor, each way

struct RectangleSide {
  float low = 0, high = 0;
  float length() const { return high - low; }
};
using Rectangle = std::array<RectangleSide, 2>;

/// Numbers of a sample of points, kSample at most.
class Sample {
 public:
  void add(float x) { numbers_[count_++] = x; }
  std::size_t count() const { return count_; }
  /// The range of all but one in `share` numbers at either end, which may be of flying points. Not of an empty sample.
  RectangleSide most(std::size_t share = 200) {
    std::sort(numbers_.begin(), numbers_.begin() + static_cast<std::ptrdiff_t>(count_));
    return {numbers_[count_ / share], numbers_[count_ - 1 - count_ / share]};
  }

 private:
  std::array<float, kSample> numbers_;  // NOLINT(cppcoreguidelines-pro-type-member-init)
  std::size_t count_ = 0;
};

class FloorSearch {
 public:
  FloorSearch(const Cloud& cloud, float epsilon, float noise, bool sides_known)
      : cloud_(cloud),
        epsilon_(epsilon),
        margin_(std::max(kMarginEpsilons * epsilon, kMarginNoise * noise)),
        step_(cloud.size / kSample + 1),
        sides_known_(sides_known) {}

  std::optional<FloorPlane> find() {
    if (!find_heights() || !find_normal() || !find_offset()) return std::nullopt;
    for (const float reach : {4.0F, 2.0F, 1.0F, 1.0F}) {
      if (!fit(std::max(margin_, reach * epsilon_))) return std::nullopt;
    }
    if (!fit(margin_) || !(plane_.normal[2] >= kLevel) || !is_floor()) return std::nullopt;
    plane_.margin = margin_;
    return plane_;
  }

 private:
  float above(const Vec3f& p) const { return plane_.normal.dot(p) - plane_.offset; }

  /// Calls visit(position, normal) for the points low enough that face up, or down if sides are not known. The normal is the one that
  /// points up.
  template <class Visit>
  void for_each_low(Visit visit) const {
    const float top = heights_.low + kLowPart * heights_.length();
    for (std::uint32_t i = 0; i < cloud_.size; ++i) {
      if (!cloud_.is_surface(i) || cloud_.position[i][2] > top) continue;
      const auto up = static_cast<float>(cloud_.normal[i].z);
      if ((sides_known_ ? up : std::abs(up)) < kUp * PackedNormal::kScale) continue;
      const Vec3f normal = cloud_.normal[i].unpack();
      visit(cloud_.position[i], up < 0 ? Vec3f(-normal) : normal);
    }
  }

  bool find_heights() {
    Sample heights;
    for (std::uint32_t i = 0; i < cloud_.size; i += step_) {
      if (cloud_.is_surface(i)) heights.add(cloud_.position[i][2]);
    }
    if (heights.count() < 100) return false;
    heights_ = heights.most();
    return heights_.length() > 0;
  }

  /// The normal that most low points have.
  bool find_normal() {
    std::uint32_t count = 0;
    Vec3f sum = Vec3f::Zero();
    for_each_low([&](const Vec3f&, const Vec3f& n) {
      sum += n;
      ++count;
    });
    if (static_cast<float>(count) < kLeastPoints * static_cast<float>(cloud_.size)) return false;
    for (int pass = 0; pass < 3; ++pass) {
      const Vec3f mean = sum / std::sqrt(sum.dot(sum));
      Vec3f alike = Vec3f::Zero();
      for_each_low([&](const Vec3f&, const Vec3f& n) {
        if (n.dot(mean) > kSameWay) alike += n;
      });
      if (!(alike.dot(alike) > 0)) return false;
      sum = alike;
    }
    plane_.normal = sum / std::sqrt(sum.dot(sum));
    return true;
  }

  /// The offset at which most low points lie, to the margin or a few bins.
  bool find_offset() {
    float least = 1e30F;
    float most = -1e30F;
    for_each_low([&](const Vec3f& p, const Vec3f&) {
      least = std::min(least, plane_.normal.dot(p));
      most = std::max(most, plane_.normal.dot(p));
    });
    const float bin = std::max((most - least) / static_cast<float>(kBins - 1), 1e-6F * epsilon_);
    std::array<std::uint32_t, kBins> counts{};
    for_each_low([&](const Vec3f& p, const Vec3f&) {
      const auto at = static_cast<std::size_t>((plane_.normal.dot(p) - least) / bin);
      ++counts[std::min(at, kBins - 1)];
    });
    const auto window = std::clamp<std::size_t>(static_cast<std::size_t>(2 * margin_ / bin), 1, kBins / 8);
    std::uint32_t sum = 0;
    std::uint32_t best = 0;
    for (std::size_t end = 0; end < kBins; ++end) {
      sum += counts[end];
      if (end >= window) sum -= counts[end - window];
      if (sum <= best) continue;
      best = sum;
      plane_.offset = least + (static_cast<float>(end + 1) - 0.5F * static_cast<float>(window)) * bin;
    }
    return best > 0;
  }

  /// Fits z = c + a x + b y to the low points within `reach` of the plane, by least squares.
  bool fit(float reach) {
    Vec3d mean = Vec3d::Zero();
    double count = 0;
    for_each_low([&](const Vec3f& p, const Vec3f&) {
      if (std::abs(above(p)) > reach) return;
      mean += p.cast<double>();
      ++count;
    });
    if (count < kLeastPoints * static_cast<double>(cloud_.size)) return false;
    mean /= count;
    Eigen::Matrix2d squares = Eigen::Matrix2d::Zero();
    Eigen::Vector2d rises = Eigen::Vector2d::Zero();
    for_each_low([&](const Vec3f& p, const Vec3f&) {
      if (std::abs(above(p)) > reach) return;
      const Vec3d d = p.cast<double>() - mean;
      squares += d.head<2>() * d.head<2>().transpose();
      rises += d.head<2>() * d[2];
    });
    if (!(squares.determinant() > 1e-6 * squares(0, 0) * squares(1, 1))) return false;
    const Eigen::Vector2d slope = squares.inverse() * rises;
    const Vec3d normal = Vec3d(-slope[0], -slope[1], 1).normalized();
    plane_.normal = normal.cast<float>();
    plane_.offset = static_cast<float>(normal.dot(mean));
    return true;
  }

  bool is_floor() const {
    std::uint32_t points = 0;
    std::uint32_t in_floor = 0;
    std::uint32_t below = 0;
    std::uint32_t in_object = 0;
    float top = 0;
    std::array<Sample, 2> floor_points;
    std::array<Sample, 2> object_points;
    const auto add = [](std::array<Sample, 2>& sample, const Vec3f& p) {
      for (int a = 0; a < 2; ++a) sample[static_cast<std::size_t>(a)].add(p[a]);
    };
    for (std::uint32_t i = 0; i < cloud_.size; ++i) {
      if (!cloud_.is_surface(i)) continue;
      const Vec3f& p = cloud_.position[i];
      const float height = above(p);
      const bool sampled = i % step_ == 0;
      ++points;
      if (height < -1.5F * margin_) {
        ++below;
      } else if (height <= margin_) {
        ++in_floor;
        if (sampled) add(floor_points, p);
      } else if (height > 2 * margin_ && p[2] <= heights_.high) {
        ++in_object;
        if (sampled) add(object_points, p);
        top = std::max(top, height);
      }
    }
    const float least = kLeastPoints * static_cast<float>(points);
    if (static_cast<float>(in_floor) < least || static_cast<float>(in_object) < least) return false;
    if (floor_points[0].count() == 0 || object_points[0].count() == 0) return false;
    const Rectangle floor{floor_points[0].most(), floor_points[1].most()};
    const Rectangle object{object_points[0].most(), object_points[1].most()};
    if (top < kLeastHeight * std::max(object[0].length(), object[1].length())) return false;
    if (!(floor[0].length() > 0 && floor[1].length() > 0)) return false;
    if (static_cast<float>(below) > kMostBelow * static_cast<float>(in_floor) && !is_turntable(floor, object)) {
      return false;
    }
    int sides = 0;
    for (std::size_t a = 0; a < 2; ++a) {
      const float reach = kReach * object[a].length();
      sides += floor[a].low < object[a].low - reach ? 1 : 0;
      sides += floor[a].high > object[a].high + reach ? 1 : 0;
    }
    return sides >= 3 && free_share(floor) > kFree;
  }

  /// Whether the floor is a disc that is wide for the object, and what lies below is a wall at its edge.
  bool is_turntable(const Rectangle& floor, const Rectangle& object) const {
    const float side = std::min(floor[0].length(), floor[1].length());
    if (std::max(object[0].length(), object[1].length()) > kMostOnRim * side) return false;
    const auto from_middle = [&](const Vec3f& p) {
      const float x = p[0] - 0.5F * (floor[0].low + floor[0].high);
      const float y = p[1] - 0.5F * (floor[1].low + floor[1].high);
      return std::sqrt(x * x + y * y);
    };
    Sample distances;
    for (std::uint32_t i = 0; i < cloud_.size; i += step_) {
      const Vec3f& p = cloud_.position[i];
      if (cloud_.is_surface(i) && std::abs(above(p)) <= margin_) distances.add(from_middle(p));
    }
    if (distances.count() == 0) return false;
    // Of a disc's points a fiftieth has more than .99 of its radius.
    const float radius = distances.most(50).high / 0.99F;
    if (radius > kRound * 0.5F * side) return false;
    std::uint32_t below = 0;
    std::uint32_t inside = 0;
    for (std::uint32_t i = 0; i < cloud_.size; ++i) {
      const Vec3f& p = cloud_.position[i];
      if (!cloud_.is_surface(i) || above(p) >= -1.5F * margin_) continue;
      ++below;
      inside += std::abs(from_middle(p) - radius) > kRim * radius ? 1 : 0;
    }
    return static_cast<float>(inside) <= kMostInside * static_cast<float>(below);
  }

  /// Share of the floor's cells in which no point of the object lies above.
  float free_share(const Rectangle& floor) const {
    std::array<std::uint8_t, kSide * kSide> cells{};  // 1: floor, 2: object
    for (std::uint32_t i = 0; i < cloud_.size; ++i) {
      if (!cloud_.is_surface(i)) continue;
      const Vec3f& p = cloud_.position[i];
      std::uint32_t at = 0;
      for (std::size_t a = 0; a < 2; ++a) {
        const float place = (p[static_cast<int>(a)] - floor[a].low) / floor[a].length() * kSide;
        at = at * kSide + static_cast<std::uint32_t>(std::clamp(place, 0.0F, kSide - 1.0F));
      }
      cells[at] = static_cast<std::uint8_t>(cells[at] | (above(p) <= margin_ ? 1U : 2U));
    }
    const auto seen = std::count_if(cells.begin(), cells.end(), [](std::uint8_t c) { return (c & 1) != 0; });
    const auto free = std::count(cells.begin(), cells.end(), 1);
    return static_cast<float>(free) / static_cast<float>(std::max<std::ptrdiff_t>(1, seen));
  }

  const Cloud& cloud_;
  float epsilon_;
  float margin_;
  std::uint32_t step_;  ///< from one point of a sample to the next
  bool sides_known_;
  RectangleSide heights_;
  FloorPlane plane_;
};

}  // namespace

std::optional<FloorPlane> find_floor(const Cloud& cloud, float epsilon, float noise, bool sides_known) {
  return FloorSearch(cloud, epsilon, noise, sides_known).find();
}

Mat3d levelling(const Vec3d& up) {
  // Rodrigues' formula for the axis up x z: R = I + [v] + [v]^2 / (1 + cos).
  const Vec3d v = up.cross(Vec3d(Vec3d::UnitZ()));
  Mat3d cross;
  cross << 0, -v[2], v[1], v[2], 0, -v[0], -v[1], v[0], 0;
  return Mat3d::Identity() + cross + cross * cross / (1 + up[2]);
}

}  // namespace plumbline::inline slicer
