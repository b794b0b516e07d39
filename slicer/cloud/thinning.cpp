#include "slicer/cloud/thinning.hpp"

#include <algorithm>
#include <array>
#include <bit>
#include <cmath>

#include "slicer/core/numbers/mix64.hpp"

namespace plumbline::inline slicer {
namespace {

/// The scan's normals face either side at random if at least one in kOften averaged points faces the opposite side of its cell,
/// and at least kFewest do. Thin walls and noise make some: 1 in 100 of a noisy scan.
constexpr std::uint64_t kOften = 10;
constexpr std::uint64_t kFewest = 8;

/// A scanner farther away than this is damage, and its square would not fit a float; scan units from the first point.
constexpr double kFarthest = 1e15;

/// The longest side of the points, but at most 8 times that of nine in ten of them: one point far away must not decide how
/// fine the cells are.
float longest_side(const Cloud& cloud) {
  constexpr std::uint32_t kSample = 512;  ///< points, evenly over the cloud's order
  constexpr float kMostCores = 8;
  const auto count = std::min(kSample, cloud.size);
  const std::uint32_t left_out = count / 20;
  float core = 0;
  for (int axis = 0; axis < 3; ++axis) {
    std::array<float, kSample> sorted;  // NOLINT(cppcoreguidelines-pro-type-member-init)
    for (std::uint32_t i = 0; i < count; ++i) sorted[i] = cloud.position[cloud.sampled(i, count)][axis];
    std::sort(sorted.begin(), sorted.begin() + count);
    core = std::max(core, sorted[count - 1 - left_out] - sorted[left_out]);
  }
  const float longest = cloud.bounds().size().maxCoeff();
  return core > 0 ? std::min(longest, kMostCores * core) : longest;
}

/// Slots of the table: the power of two that leaves it 1/3 to 2/3 full when the cloud is.
std::size_t slots_for(std::uint32_t capacity) { return std::bit_ceil(std::size_t{capacity} * 3 / 2 + 16); }

}  // namespace

std::size_t PointThinner::table_bytes(std::uint32_t capacity) { return slots_for(capacity) * sizeof(std::uint32_t); }

PointThinner::PointThinner(Cloud& cloud, std::uint32_t capacity, std::span<std::byte> table, const Mat3d& rotation,
                           double cell)
    : cloud_(cloud),
      capacity_(capacity),
      table_(std::span(reinterpret_cast<std::uint32_t*>(table.data()), slots_for(capacity))),
      index_mask_(std::bit_ceil(capacity + 1) - 1),
      rotation_(rotation),
      pose_{rotation, Vec3d::Zero()},
      cell_(cell) {
  table_.clear();
}

void PointThinner::begin(const ScanHeader& header, const ScanPose& pose) {
  pose_ = {rotation_ * pose.rotation, rotation_ * pose.translation};
  unsigned_normals_ = unsigned_normals_ || header.has_unsigned_normals;
  seen_before_ = seen_;
}

void PointThinner::begin_view(const ScanView& view) {
  view_ = view;
  view_number_.reset();
}

std::uint8_t PointThinner::number_of(const ScanView& view) {
  CloudViews& views = cloud_.views;
  if (views.of.empty()) return kNoView;
  const Vec3d local =
      view.scanner ? Vec3d(pose_.rotation * *view.scanner + pose_.translation - offset_) : Vec3d::Zero();
  const bool has_scanner = view.scanner && local.squaredNorm() < kFarthest * kFarthest;
  const Vec3f place = has_scanner ? Vec3f(local.cast<float>()) : Vec3f::Zero();
  if (views.count < kMaxViews) {
    views.scanner[views.count] = place;
    views.has_scanner[views.count] = has_scanner;
    return static_cast<std::uint8_t>(views.count++);
  }
  std::uint8_t nearest = kNoView;
  for (std::uint8_t v = 0; has_scanner && v < kMaxViews; ++v) {
    if (!views.has_scanner[v]) continue;
    if (nearest == kNoView ||
        (views.scanner[v] - place).squaredNorm() < (views.scanner[nearest] - place).squaredNorm()) {
      nearest = v;
    }
  }
  return nearest;
}

PointThinner::Key PointThinner::key_of(const Vec3f& p) const {
  // All coordinates beyond 1e18 cells share a cell, so the conversion can't overflow. No intact scan is that large.
  const auto index = [&](float v) {
    const double cells = std::clamp(static_cast<double>(v) / cell_, -1e18, 1e18);
    const auto towards_0 = static_cast<std::int64_t>(cells);  // rounding down is a call on some machines
    return towards_0 - (cells < static_cast<double>(towards_0) ? 1 : 0);
  };
  return {index(p[0]), index(p[1]), index(p[2])};
}

std::uint64_t PointThinner::hash_of(const Key& key) {
  std::uint64_t hash = static_cast<std::uint64_t>(key.x) * kGoldenStep64;
  hash = (hash ^ (hash >> 32)) + static_cast<std::uint64_t>(key.y) * 0xC2B2AE3D27D4EB4FU;
  hash = (hash ^ (hash >> 29)) + static_cast<std::uint64_t>(key.z) * 0x165667B19E3779F9U;
  return (hash ^ (hash >> 32)) * kGoldenStep64;
}

std::uint32_t PointThinner::slot_of(const Key& key, std::uint64_t hash) const {
  return table_.find(hash >> 20, [&](std::uint32_t entry) {
    return (entry & ~index_mask_) == tag_of(hash) && key_of(cloud_.position[place_of(entry)]) == key;
  });
}

void PointThinner::merge(std::uint32_t place, const Vec3f& p, const PackedNormal& normal) {
  PackedNormal& kept = cloud_.normal[place];
  const auto a = static_cast<float>(kept.weight);
  const auto b = static_cast<float>(normal.weight);
  cloud_.position[place] += (p - cloud_.position[place]) * (b / (a + b));
  if (normal.known()) {
    if (kept.known()) {
      const Vec3f mean = kept.unpack();
      const Vec3f more = normal.unpack();
      const bool opposite = mean.dot(more) < -kOneWay;
      opposite_ += opposite ? 1 : 0;
      // Opposite normals would cancel. Where sides are random only the direction counts; complete_normals() finds the side.
      const bool random = opposite_ >= kFewest && kOften * opposite_ > averaged_;
      const bool turned = unsigned_normals_ ? mean.dot(more) < 0 : opposite && random;
      kept.set(mean * a + more * (turned ? -b : b));
    } else {
      kept.set(normal.unpack());
    }
  }
  // From 255 points on, the mean is a moving one that favours later points. In a cell below the pixel pitch that can't show.
  kept.weight = static_cast<std::uint8_t>(std::min(255, kept.weight + normal.weight));
}

void PointThinner::add(const Incoming& point) {
  if (cell_ > 0) {
    const std::uint32_t slot = slot_of(point.key, point.hash);
    if (table_[slot] != 0) {
      const std::uint32_t place = place_of(table_[slot]);
      merge(place, point.position, point.normal);
      // The mean of points at a cell's side may round to the other side.
      table_[slot] = (place + 1) | tag_of(hash_of(key_of(cloud_.position[place])));
      ++averaged_;
      return;
    }
    if (cloud_.size < capacity_) table_[slot] = (cloud_.size + 1) | tag_of(point.hash);
  }
  if (cloud_.size == capacity_) {
    grow_cell();
    Incoming again = point;
    find_cell(again);
    add(again);
    return;
  }
  cloud_.position[cloud_.size] = point.position;
  cloud_.normal[cloud_.size] = point.normal;
  if (cloud_.views) cloud_.views.of[cloud_.size] = point.view;
  ++cloud_.size;
}

void PointThinner::find_cell(Incoming& point) const {
  point.key = key_of(point.position);
  point.hash = hash_of(point.key);
}

void PointThinner::add(std::span<Incoming> points) {
  const double cell = cell_;
  if (cell > 0) {
    for (Incoming& point : points) {
      find_cell(point);
      __builtin_prefetch(&table_[table_.first(point.hash >> 20)]);
    }
    for (const Incoming& point : points) {
      const std::uint32_t entry = table_[table_.first(point.hash >> 20)];
      if (entry == 0) continue;
      __builtin_prefetch(&cloud_.position[place_of(entry)]);
      __builtin_prefetch(&cloud_.normal[place_of(entry)]);
    }
  }
  for (Incoming& point : points) {
    if (cell_ != cell) find_cell(point);  // it has grown meanwhile
    add(point);
  }
}

void PointThinner::grow_cell() {
  // Eight cells meet at the origin, so cells of any size may leave eight points.
  const auto goal = std::max<std::uint32_t>(8, static_cast<std::uint32_t>(kRefill * capacity_));
  do {
    if (cell_ > 0) {
      cell_ *= 2;
    } else {
      // 1/4096 of the longest side is finer than most panels' pixels, so little is lost before cells have to grow.
      const float longest = longest_side(cloud_);
      cell_ = longest > 0 ? static_cast<double>(longest) / 4096 : 1.0;
    }
    table_.clear();
    const std::uint32_t count = cloud_.size;
    cloud_.size = 0;
    std::array<Incoming, kTogether> points;
    for (std::uint32_t i = 0; i < count;) {
      std::uint32_t held = 0;
      for (; held < kTogether && i < count; ++held, ++i) {
        points[held].position = cloud_.position[i];
        points[held].normal = cloud_.normal[i];
        points[held].view = cloud_.view_of(i);
      }
      add(std::span(points).first(held));
    }
  } while (cloud_.size > goal);
}

Status PointThinner::take(std::span<const ScanPoint> points) {
  std::array<Incoming, kTogether> incoming;
  std::uint32_t held = 0;
  for (const ScanPoint& point : points) {
    const Vec3d rotated = pose_.rotation * Vec3d(point.x, point.y, point.z) + pose_.translation;
    if (seen_++ == 0) offset_ = rotated;
    const Vec3f local = (rotated - offset_).cast<float>();
    if (!(std::abs(local[0]) < 1e18F && std::abs(local[1]) < 1e18F && std::abs(local[2]) < 1e18F)) {
      return fail(
          ErrorCode::kMalformed,
          "point %llu lies at (%g, %g, %g), more than 1e18 from the first one: the file is damaged.\tExport it again",
          static_cast<unsigned long long>(seen_ - seen_before_), point.x, point.y, point.z);
    }
    if (!view_number_) view_number_ = number_of(view_);
    Incoming& taken = incoming[held++];
    taken.view = *view_number_;
    taken.position = local;
    taken.normal = {};
    taken.normal.set((pose_.rotation * Vec3d(point.nx, point.ny, point.nz)).cast<float>());
    if (held == kTogether) {
      add(incoming);
      held = 0;
    }
  }
  add(std::span(incoming).first(held));
  return {};
}

}  // namespace plumbline::inline slicer
