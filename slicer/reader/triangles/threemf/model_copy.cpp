#include "slicer/reader/triangles/threemf/model_copy.hpp"

#include <algorithm>
#include <cstring>
#include <memory>
#include <utility>

namespace plumbline::inline slicer {
namespace {

/// Triangles between two reports of progress: fewer milliseconds than a person notices.
constexpr std::uint64_t kReportEvery = 1U << 16U;

/// The most bytes of a corner: 7 bits each of 64.
constexpr std::size_t kMostCornerBytes = 10;

/// Numbers 0, -1, 1, -2 ... as 0, 1, 2, 3 ..., so that a small difference of either sign takes one byte.
std::uint64_t folded(std::uint64_t difference) { return (difference << 1U) ^ (0 - (difference >> 63U)); }
std::uint64_t unfolded(std::uint64_t number) { return (number >> 1U) ^ (0 - (number & 1U)); }

/// Writes seven bits a byte, the lowest first; the eighth says that more follow.
std::size_t write_number(std::uint64_t number, std::byte* at) {
  std::size_t count = 0;
  for (; number > 0x7f; number >>= 7U) at[count++] = static_cast<std::byte>((number & 0x7fU) | 0x80U);
  at[count++] = static_cast<std::byte>(number);
  return count;
}

std::uint64_t read_number(const std::byte*& at) {
  std::uint64_t number = 0;
  for (unsigned shift = 0;; shift += 7) {
    const auto byte = static_cast<std::uint64_t>(*at++);
    number |= (byte & 0x7fU) << shift;
    if (byte < 0x80) return number;
  }
}

}  // namespace

Status PlacedTriangles::add(const Triangle& corners) {
  if (number_ >= end_) role_ = parts_.role_of(mesh_, number_, end_);
  ++number_;
  for (const MeshInstance& instance : parts_.instances()) {
    const VolumeRole role = std::max(role_, instance.role);
    if (role == VolumeRole::kIgnored) continue;
    if (parts_.has_negative()) {
      PLUMBLINE_TRY(batch_.begin_body(BodyLabel(instance.item, role == VolumeRole::kNegative)));
    }
    const Affine& place = instance.place;
    Triangle t;
    for (std::size_t k = 0; k < 3; ++k) t[k] = place(corners[k]) * unit_mm_;
    if (place.linear.determinant() < 0) std::swap(t[1], t[2]);
    PLUMBLINE_TRY(batch_.add(t));
  }
  return {};
}

ModelCopy::ModelCopy(std::span<std::byte> room) : room_(room), is_whole_(!room.empty()) {}

std::byte* ModelCopy::take(std::size_t bytes) {
  if (!is_whole_ || bytes > room_.size() - used_) {
    give_up();
    return nullptr;
  }
  std::byte* const taken = room_.data() + used_;
  used_ += bytes;
  return taken;
}

void ModelCopy::close_object() {
  if (is_open_ && is_whole_) {
    std::memcpy(room_.data() + head_at_, &head_, sizeof head_);
    take(padded(used_) - used_);
  }
  is_open_ = false;
}

void ModelCopy::begin_object(const ObjectKey& key, bool is_solid) {
  close_object();
  head_ = {.key = key, .is_solid = is_solid};
  head_at_ = used_;
  is_open_ = take(sizeof head_) != nullptr;
  last_corner_ = 0;
}

bool ModelCopy::add_vertex(const Vec3d& p) {
  if (head_.triangles > 0) give_up();
  std::byte* const at = take(sizeof(Vec3f));
  if (at == nullptr) return false;
  if (head_.vertices++ == 0) {
    const Vec3d origin = VertexList::origin_at(p);
    head_.origin = {origin[0], origin[1], origin[2]};
  }
  const Vec3f offset = VertexList::offset_from({head_.origin[0], head_.origin[1], head_.origin[2]}, p);
  std::memcpy(at, offset.data(), sizeof(Vec3f));
  return true;
}

bool ModelCopy::add_triangle(const std::array<std::uint64_t, 3>& corners) {
  std::byte* const begin = take(3 * kMostCornerBytes);
  if (begin == nullptr) return false;
  std::size_t written = 0;
  for (const std::uint64_t corner : corners) {
    if (corner >= head_.vertices) {
      give_up();
      return false;
    }
    written += write_number(folded(corner - last_corner_), begin + written);
    last_corner_ = corner;
  }
  used_ -= 3 * kMostCornerBytes - written;
  ++head_.triangles;
  head_.corner_bytes += written;
  return true;
}

ModelCopy::Object ModelCopy::object_at(std::size_t& at) const {
  Object object;
  std::memcpy(&object.head, room_.data() + at, sizeof(Head));
  object.vertices = room_.data() + at + sizeof(Head);
  object.corners = object.vertices + static_cast<std::size_t>(object.head.vertices) * sizeof(Vec3f);
  at = padded(static_cast<std::size_t>(object.corners - room_.data()) +
              static_cast<std::size_t>(object.head.corner_bytes));
  return object;
}

bool ModelCopy::finish(ModelParts& parts, double unit_mm, std::uint64_t bytes, const UnusedSettings& project) {
  close_object();
  end_ = used_;
  for (std::size_t at = 0; at < end_ && is_whole_;) {
    const Head head = object_at(at).head;
    const bool is_new = parts.declare(head.key);
    if (!is_new || (head.is_solid && parts.find_instances(head.key) != ModelParts::Found::kAll)) give_up();
  }
  const auto places = parts.places();
  const auto volumes = parts.volumes();
  std::byte* const copy = take(places.size_bytes() + volumes.size_bytes());
  if (copy == nullptr) {
    parts.forget_declared();
    return false;
  }
  std::ranges::uninitialized_copy(places, std::span(reinterpret_cast<ModelParts::Place*>(copy), places.size()));
  std::ranges::uninitialized_copy(
      volumes, std::span(reinterpret_cast<ModelParts::Volume*>(copy + places.size_bytes()), volumes.size()));
  places_ = places.size();
  volumes_ = volumes.size();
  project_ = project;
  root_ = parts.root();
  unit_mm_ = unit_mm;
  file_bytes_ = bytes;
  return true;
}

Expected<ModelParts> ModelCopy::parts(Arena& memory) const {
  const std::span places(reinterpret_cast<ModelParts::Place*>(room_.data() + end_), places_);
  auto* const volumes = reinterpret_cast<ModelParts::Volume*>(room_.data() + end_ + places.size_bytes());
  return ModelParts::of(places, {volumes, volumes_}, root_, memory);
}

Status ModelCopy::deliver(ModelParts& parts, TriangleBatch& batch, double done) const {
  MeshSummary& summary = batch.summary();
  for (std::size_t at = 0; at < end_;) {
    const Object object = object_at(at);
    if (!object.head.is_solid || parts.find_instances(object.head.key) != ModelParts::Found::kAll) continue;
    const auto places = parts.instances();
    if (places.empty()) continue;
    const Vec3d origin(object.head.origin[0], object.head.origin[1], object.head.origin[2]);
    const auto position = [&](std::uint64_t i) {
      Vec3f offset;
      std::memcpy(offset.data(), object.vertices + static_cast<std::size_t>(i) * sizeof(Vec3f), sizeof(Vec3f));
      return Vec3d(offset.cast<double>() + origin);
    };
    const std::uint64_t report_every = std::max<std::uint64_t>(1, kReportEvery / places.size());
    PlacedTriangles placed(parts, object.head.key, unit_mm_, batch);
    const std::byte* next = object.corners;
    std::uint64_t corner = 0;
    for (std::uint64_t i = 0; i < object.head.triangles; ++i) {
      Triangle t;
      for (Vec3d& p : t) p = position(corner += unfolded(read_number(next)));
      PLUMBLINE_TRY(placed.add(t));
      if (i % report_every == 0) {
        const double share = static_cast<double>(next - room_.data()) / static_cast<double>(end_);
        PLUMBLINE_TRY(batch.report(done + (1 - done) * share));
      }
    }
    summary.faces += object.head.triangles;
    summary.vertices += object.head.vertices;
    summary.used_vertices += object.head.vertices;  // nobody asks: a 3MF is a mesh however many it uses
    summary.most_vertices = std::max(summary.most_vertices, object.head.vertices);
  }
  return {};
}

}  // namespace plumbline::inline slicer
