#include "slicer/reader/triangles/threemf/model_parts.hpp"

#include <algorithm>
#include <charconv>

#include "slicer/core/numbers/mix64.hpp"
#include "slicer/reader/stream/words.hpp"
#include "slicer/reader/stream/xml_parser.hpp"

namespace plumbline {
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
  auto parts = of(*places, part_key("3D/3dmodel.model"), memory);
  PLUMBLINE_TRY(parts);
  parts->size_ = 0;
  return parts;
}

Expected<ModelParts> ModelParts::of(std::span<Place> places, std::uint64_t root, Arena& memory) {
  ModelParts parts;
  parts.places_ = places;
  parts.size_ = places.size();
  parts.root_ = root;
  PLUMBLINE_TRY(memory.take_bottom(parts.instances_, kMostInstances, kStage));
  return parts;
}

bool ModelParts::add(const ObjectKey& child, const ObjectKey& in, const Affine& place) {
  if (size_ == places_.size()) return false;
  const auto end = places_.begin() + static_cast<std::ptrdiff_t>(size_++);
  const auto at =
      std::upper_bound(places_.begin(), end, child, [](const ObjectKey& key, const Place& p) { return key < p.child; });
  std::copy_backward(at, end, end + 1);
  *at = {child, in, place, false, false};
  return true;
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
  return follow(mesh, {}, 0);
}

/// @param so_far  from the mesh to the object
ModelParts::Found ModelParts::follow(const ObjectKey& object, const Affine& so_far, std::uint32_t depth) {
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
    if (place.in.id == 0) {
      if (count_ == instances_.size()) return Found::kTooMany;
      instances_[count_++] = on;
      continue;
    }
    const Found found = follow(place.in, on, depth + 1);
    if (found != Found::kAll) return found;
  }
  return Found::kAll;
}

}  // namespace plumbline
