#include "slicer/reader/triangles/threemf/model_parts.hpp"

#include <algorithm>
#include <charconv>

#include "slicer/core/numbers/mix64.hpp"
#include "slicer/reader/stream/words.hpp"
#include "slicer/reader/stream/xml_parser.hpp"

namespace plumbline::inline slicer {
namespace {

constexpr const char* kStage = "reading 3MF";

}  // namespace

std::optional<Affine> parse_transform(std::string_view text) {
  Affine transform;
  LineWords words(text, kXmlBlanks);
  auto word = words.next();
  if (word.empty()) return transform;
  for (int row = 0; row < 4; ++row) {
    for (int column = 0; column < 3; ++column, word = words.next()) {
      double& number = row < 3 ? transform.linear(column, row) : transform.shift[column];
      if (!parse_number(word, number)) return std::nullopt;
    }
  }
  return word.empty() ? std::optional(transform) : std::nullopt;
}

std::uint64_t part_key(std::string_view path) {
  if (path.starts_with('/')) path.remove_prefix(1);
  std::uint64_t key = 0;
  while (!path.empty()) {
    unsigned byte = static_cast<unsigned char>(path.front());
    std::size_t length = 1;
    if (byte == '%' && path.size() >= 3) {
      const char* const code = path.data() + 1;
      if (std::from_chars(code, code + 2, byte, 16).ptr == code + 2) length = 3;
    }
    path.remove_prefix(length);
    if (byte == '\\') byte = '/';  // as some programs on Windows write
    key = mix64(key + kGoldenStep64 + (byte >= 'A' && byte <= 'Z' ? byte - 'A' + 'a' : byte));
  }
  return key;
}

Expected<ModelParts> ModelParts::create(Arena& memory) {
  const auto places = memory.take_bottom<Place>(kMostPlaces, kStage);
  PLUMBLINE_TRY(places);
  const auto volumes = memory.take_bottom<Volume>(kMostVolumes, kStage);
  PLUMBLINE_TRY(volumes);
  auto parts = of(*places, *volumes, part_key("3D/3dmodel.model"), memory);
  PLUMBLINE_TRY(parts);
  parts->size_ = parts->volume_count_ = 0;
  parts->has_negative_ = false;
  return parts;
}

Expected<ModelParts> ModelParts::of(std::span<Place> places, std::span<Volume> volumes, std::uint64_t root,
                                    Arena& memory) {
  ModelParts parts;
  parts.places_ = places;
  parts.size_ = places.size();
  parts.volumes_ = volumes;
  parts.volume_count_ = volumes.size();
  parts.root_ = root;
  parts.has_negative_ = std::ranges::any_of(volumes, [](const Volume& v) { return v.role == VolumeRole::kNegative; });
  PLUMBLINE_TRY(memory.take_bottom(parts.instances_, kMostInstances, kStage));
  return parts;
}

bool ModelParts::add(const ObjectKey& child, const ObjectKey& in, const Affine& place) {
  if (size_ == places_.size()) return false;
  const auto end = places_.begin() + static_cast<std::ptrdiff_t>(size_++);
  const auto at =
      std::upper_bound(places_.begin(), end, child, [](const ObjectKey& key, const Place& p) { return key < p.child; });
  std::copy_backward(at, end, end + 1);
  *at = {child, in, place, VolumeRole::kSolid, false, false};
  return true;
}

bool ModelParts::add(const Volume& volume) {
  if (volume_count_ == volumes_.size()) return false;
  volumes_[volume_count_++] = volume;
  has_negative_ |= volume.role == VolumeRole::kNegative;
  return true;
}

void ModelParts::assign_roles() {
  for (Volume& volume : volumes_.first(volume_count_)) {
    if (volume.in.part == 0) volume.in.part = root_;
    if (volume.child == 0) continue;
    for (Place& place : places_.first(size_)) {
      if (place.in == volume.in && place.child.id == volume.child) place.role = std::max(place.role, volume.role);
    }
  }
}

void ModelParts::count_roles(UnusedSettings& project) const {
  for (const Volume& volume : volumes()) ++(volume.role == VolumeRole::kNegative ? project.negative : project.ignored);
}

VolumeRole ModelParts::role_of(const ObjectKey& mesh, std::uint32_t first, std::uint32_t& end) const {
  VolumeRole role = VolumeRole::kSolid;
  end = kAllTriangles;
  for (const Volume& volume : volumes()) {
    if (volume.in != mesh || volume.child != 0 || volume.last < first) continue;
    if (volume.first > first) {
      end = std::min(end, volume.first);
      continue;
    }
    role = std::max(role, volume.role);
    if (volume.last != kAllTriangles) end = std::min(end, volume.last + 1);
  }
  return role;
}

bool ModelParts::declare(const ObjectKey& object) {
  for (Place& place : places_.first(size_)) {
    place.in_declared |= place.in == object;
    if (place.child != object) continue;
    if (place.declared) return false;
    place.declared = true;
  }
  return true;
}

void ModelParts::forget_declared() {
  for (Place& place : places_.first(size_)) place.declared = place.in_declared = false;
}

bool ModelParts::places_anything() const {
  const auto used = places_.first(size_);
  return std::any_of(used.begin(), used.end(), [&](const Place& p) { return p.in.id == 0 && p.in.part == root_; });
}

std::optional<std::uint32_t> ModelParts::missing() const {
  for (const Place& place : places_.first(size_)) {
    const bool counts = place.in.id == 0 ? place.in.part == root_ : place.in_declared;
    if (counts && !place.declared) return place.child.id;
  }
  return std::nullopt;
}

ModelParts::Found ModelParts::find_instances(const ObjectKey& mesh) {
  count_ = 0;
  steps_ = 0;
  return follow(mesh, {}, VolumeRole::kSolid, 0);
}

/// @param so_far  from the mesh to the object
/// @param role    of the mesh in the object
ModelParts::Found ModelParts::follow(const ObjectKey& object, const Affine& so_far, VolumeRole role,
                                     std::uint32_t depth) {
  if (depth > kMostNested) return Found::kTooDeep;
  if (++steps_ > kMostSteps) return Found::kTooMany;
  // A search among all places in each step would take minutes for a small file of components within components.
  const auto end = places_.begin() + static_cast<std::ptrdiff_t>(size_);
  auto at = std::lower_bound(places_.begin(), end, object,
                             [](const Place& p, const ObjectKey& key) { return p.child < key; });
  for (; at != end && at->child == object; ++at) {
    const Place& place = *at;
    if (place.in.id == 0 && place.in.part != root_) continue;
    const Affine on{place.place.linear * so_far.linear, place.place(so_far.shift)};
    const VolumeRole role_here = std::max(role, place.role);
    if (place.in.id == 0) {
      if (count_ == instances_.size()) return Found::kTooMany;
      instances_[count_++] = {on, static_cast<std::uint32_t>(&place - places_.data()) + 1, role_here};
      continue;
    }
    const Found found = follow(place.in, on, role_here, depth + 1);
    if (found != Found::kAll) return found;
  }
  return Found::kAll;
}

}  // namespace plumbline::inline slicer
