#pragma once
/// The scan in memory: 25 bytes a point in the arena, 24 once rays are shot.

#include <algorithm>
#include <cstdint>
#include <optional>
#include <span>

#include "slicer/core/arena.hpp"
#include "slicer/core/function_ref.hpp"
#include "slicer/core/numbers/vec.hpp"

namespace plumbline::inline slicer {

/// Least inner product of the normals of points that face one way: within 60 degrees. They face opposite ways below -kOneWay.
inline constexpr float kOneWay = 0.5F;

/// Largest mean height of a point over its neighbours' planes, over their distance, for a point on their sheet. Estimated normals at a
/// corner make up to 0.1; a point straight above a sheet has 1.
inline constexpr float kMostHeight = 0.2F;
/// Fewest points that make a sheet, one that few views saw.
inline constexpr std::uint32_t kSparsePoints = 8;

/// |n_z| below which a unit normal is neutral: sin(5 degrees), the thesis' tolerance for the error of a scanned normal.
inline constexpr float kNeutralSine = 0.087155743F;

/// Classes of points (thesis III-2.b, table 1).
enum class PointClass : std::uint8_t {
  kEntering,  ///< normal against the manufacturing direction: rays going up enter here
  kExiting,   ///< normal along the manufacturing direction
  kNeutral,   ///< normal within 5 degrees of perpendicular to it
  kNoise,     ///< in no cluster: too few neighbours of like orientation
};
inline constexpr std::size_t kPointClassCount = 4;

/// A unit normal in 6 bytes (error below 0.003 degrees), with the point's weight and class. All zero: no normal is known.
/// Until join_points(), the weight counts points of the scan that thinning has averaged; after it, points that it has joined.
struct PackedNormal {
  std::int16_t x = 0, y = 0, z = 0;  ///< component * 32767
  std::uint8_t weight = 1;           ///< points that this one stands for, at most 255
  PointClass point_class = PointClass::kNoise;

  static constexpr float kScale = 32767.0F;
  bool known() const { return x != 0 || y != 0 || z != 0; }
  Vec3f unpack() const {
    constexpr float kInverse = 1.0F / kScale;
    return {static_cast<float>(x) * kInverse, static_cast<float>(y) * kInverse, static_cast<float>(z) * kInverse};
  }
  /// Sets the direction of n, which must be finite. Shorter than 1e-12, it means that no normal is known.
  void set(const Vec3f& n);
  void turn_over() {
    x = static_cast<std::int16_t>(-x);
    y = static_cast<std::int16_t>(-y);
    z = static_cast<std::int16_t>(-z);
  }
};
static_assert(sizeof(PackedNormal) == 8);

/// Number of a point's view if nobody says which it is.
inline constexpr std::uint8_t kNoView = 255;
inline constexpr std::uint32_t kMaxViews = kNoView;
/// Parts that a scan without views is divided into, in the order of its file: points that were taken together share an error. Of the
/// raw bunny and dragon, whose views follow each other, 16 find as much, 128 are too small.
inline constexpr std::uint32_t kRuns = 32;

/// The views of a scan, as its files state them; else runs of points in the order of the file.
struct CloudViews {
  std::span<std::uint8_t> of;  ///< number of each point's view, or kNoView; as many as the cloud has room for
  /// Where each view's scanner stood, in the frame and unit of the cloud until it is placed. kMaxViews of them, `count` in use.
  std::span<Vec3f> scanner;
  std::span<bool> has_scanner;  ///< whether the file says so
  std::uint32_t count = 0;
  bool are_runs = false;

  /// Whether points have views: they keep them until rays are shot.
  explicit operator bool() const { return !of.empty(); }
  /// How many views' scanners have a known place.
  std::uint32_t scanners() const {
    return static_cast<std::uint32_t>(std::ranges::count(has_scanner.first(count), true));
  }
  /// Whether a view's scanner has a known place.
  bool knows_scanner(std::uint8_t view) const { return view < count && has_scanner[view]; }
  /// Unit vector from a view's scanner to a point.
  /// @returns none if the scanner's place is unknown
  std::optional<Vec3d> ray(std::uint8_t view, const Vec3f& point) const {
    if (!knows_scanner(view)) return std::nullopt;
    return (point - scanner[view]).cast<double>().normalized();
  }
};

/// One array for each property, all of one capacity. Index i is the same point in all of them and in both trees: this is the
/// link of thesis III-2.a.
struct Cloud {
  std::span<Vec3f> position;  ///< mm; scan frame less an offset until placed, print coordinates after
  std::span<PackedNormal> normal;
  /// Radius of the disc around a point that holds `support_points` points at the density of the surface there, in the unit
  /// of `position`. pi radius^2 / support_points is the area that the point stands for, times its weight once points are
  /// joined. Normals and clustering set it; MLS takes it as the support radius.
  std::span<float> radius;
  CloudViews views;          ///< none after neighbours have been averaged, and when rays are shot
  float support_points = 1;  ///< points that each disc holds; 1: the disc is the point's own share of the surface
  std::uint32_t size = 0;    ///< points in use

  static constexpr std::size_t kBytesPerPoint = sizeof(Vec3f) + sizeof(PackedNormal) + sizeof(float);
  /// The same with the number of its view, as a scan has it until rays are shot.
  static constexpr std::size_t kBytesPerSeenPoint = kBytesPerPoint + 1;

  [[nodiscard]] static Expected<Cloud> create(std::uint32_t capacity, Arena& arena, bool with_views = false);
  std::uint32_t capacity() const { return static_cast<std::uint32_t>(position.size()); }
  std::span<const Vec3f> positions() const { return position.first(size); }
  bool is_surface(std::uint32_t i) const { return normal[i].point_class != PointClass::kNoise; }
  /// Divides the points, which are in the order of the file, into runs.
  void set_runs();
  std::uint8_t view_of(std::uint32_t i) const { return views ? views.of[i] : kNoView; }
  /// Whether the scanner that saw point i has a known place.
  bool has_scanner(std::uint32_t i) const { return views.knows_scanner(view_of(i)); }
  /// Point k of a sample of `count` points, at equal steps of the order.
  std::uint32_t sampled(std::uint32_t k, std::uint32_t count) const {
    return static_cast<std::uint32_t>(std::uint64_t{k} * size / count);
  }
  Box3f bounds() const;
  /// False if all points lie along one line, to rounding, or there is none.
  bool spans_area() const;

  /// Changes all radii to those of discs that hold `points` points, above 0.
  void set_support_points(float points);

  /// Replaces every two to four neighbours by their mean. To find them, the cloud is halved across its longest side, and each half
  /// again, until at most four points are left. Normals are unknown afterwards, and every weight is 1.
  void average_neighbours();

  /// Removes the points for which stays(i) is false and keeps the order of the others.
  void keep(FunctionRef<bool(std::uint32_t)> stays);
  /// Removes the points of class kNoise and keeps the order of the others.
  void drop_noise();

  /// Gives the room of points that are not in use back to the arena, where nothing else has been taken at the top since create() or has
  /// been released.
  /// @retval ErrorCode::kOutOfMemory  only in an arena that refuses a block; the points are lost
  [[nodiscard]] Status give_back(Arena& arena, bool with_views = true);

  /// Moves point order[i] to i, for every i.
  /// @param order  such as that of a tree; out: 0, 1, 2, ...
  void reorder(std::span<std::uint32_t> order);
};

}  // namespace plumbline::inline slicer
