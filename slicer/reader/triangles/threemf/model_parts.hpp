#pragma once
/// Where the objects of a 3MF file stand: build items and components, with their transforms.

#include <array>
#include <cstdint>
#include <optional>
#include <span>
#include <string_view>

#include "slicer/core/arena.hpp"
#include "slicer/core/numbers/vec.hpp"
#include "slicer/reader/triangles/triangle.hpp"

namespace plumbline::inline slicer {

/// x -> linear x + shift
struct Affine {
  Mat3d linear = Mat3d::Identity();
  Vec3d shift = Vec3d::Zero();

  Vec3d operator()(const Vec3d& x) const { return linear * x + shift; }
};

/// Parses a transform of 3MF: twelve numbers, row after row of a matrix of four rows that a row vector is multiplied by.
/// @param text  empty: no transform
/// @returns nothing if it is not twelve finite numbers
std::optional<Affine> parse_transform(std::string_view text);

/// An object's name: objects of different model parts of a file may have the same number.
struct ObjectKey {
  std::uint64_t part = 0;  ///< part_key() of its model part
  std::uint32_t id = 0;    ///< from 1; 0 is the build

  friend bool operator==(const ObjectKey&, const ObjectKey&) = default;
  friend bool operator<(const ObjectKey& a, const ObjectKey& b) {
    return a.part != b.part ? a.part < b.part : a.id < b.id;
  }
};

/// @param path  of a part: "/3D/one%20part.model" is the same as "3d/one part.model" (ECMA-376-2, 6.2.2)
std::uint64_t part_key(std::string_view path);

/// A copy of a mesh that is printed.
struct MeshInstance {
  Affine place;
  std::uint32_t item = 0;  ///< from 1
  VolumeRole role = VolumeRole::kSolid;
};

/// All build items and components, and what a project says of them.
class ModelParts {
 public:
  static constexpr std::size_t kMostVolumes = 256;    ///< that are no solids
  static constexpr std::size_t kMostPlaces = 1024;    ///< items and components
  static constexpr std::size_t kMostInstances = 512;  ///< of one mesh
  static constexpr std::uint32_t kMostSteps = 16384;  ///< of the search for them
  static constexpr std::uint32_t kMostNested = 32;    ///< components within components

  enum class Found : std::uint8_t { kAll, kTooMany, kTooDeep };

  struct Place {
    ObjectKey child;
    ObjectKey in;
    Affine place;
    VolumeRole role;
    bool declared;     ///< declare() was called for the child
    bool in_declared;  ///< and for the object that it is in
  };

  /// Part of an object that is no solid.
  static constexpr std::uint32_t kAllTriangles = ~std::uint32_t{0};
  struct Volume {
    ObjectKey in;             ///< part 0: of the root
    std::uint32_t child = 0;  ///< a component; 0: triangles of the object itself
    std::uint32_t first = 0, last = kAllTriangles;
    VolumeRole role = VolumeRole::kIgnored;
  };

  [[nodiscard]] static Expected<ModelParts> create(Arena& memory);
  /// Those that were found before.
  /// @param places, volumes  those of other parts; stay in use
  [[nodiscard]] static Expected<ModelParts> of(std::span<Place> places, std::span<Volume> volumes, std::uint64_t root,
                                               Arena& memory);

  /// Sorted by child, those of one child in the order in which they were added.
  std::span<const Place> places() const { return places_.first(size_); }

  /// @param child  the object that stands there
  /// @param in     the object that has it as a component; id 0 if it is an item of that part's build
  /// @returns false if there is no room
  [[nodiscard]] bool add(const ObjectKey& child, const ObjectKey& in, const Affine& place);

  /// @returns false if there is no room
  [[nodiscard]] bool add(const Volume& volume);
  std::span<const Volume> volumes() const { return volumes_.first(volume_count_); }
  /// After all places and volumes have been added: gives the places their roles.
  void assign_roles();
  /// Adds to `project` how many volumes have a role.
  void count_roles(UnusedSettings& project) const;

  /// What triangles of a mesh are.
  /// @param first  of them
  /// @param end    set to the first triangle from which on they may be something else
  VolumeRole role_of(const ObjectKey& mesh, std::uint32_t first, std::uint32_t& end) const;
  /// Whether something is cut out of solids.
  bool has_negative() const { return has_negative_; }

  /// Makes a part's build the one that is printed, and its unit the file's. The others don't count.
  void set_root(std::uint64_t part) { root_ = part; }
  std::uint64_t root() const { return root_; }

  /// Notes that the file has this object.
  /// @returns false if it is placed and there was one with the same key before
  [[nodiscard]] bool declare(const ObjectKey& object);
  /// As if declare() had never been called.
  void forget_declared();

  /// Whether the root's build places an object.
  bool places_anything() const;
  /// @returns the id of an object that is placed in the root's build or in an object of the file, and that declare() was not called for
  std::optional<std::uint32_t> missing() const;

  /// Finds the transform of each copy of a mesh that is printed.
  Found find_instances(const ObjectKey& mesh);
  /// As found last.
  std::span<const MeshInstance> instances() const { return instances_.first(count_); }

 private:
  Found follow(const ObjectKey& object, const Affine& so_far, VolumeRole role, std::uint32_t depth);

  std::span<Place> places_;
  std::size_t size_ = 0;
  std::span<Volume> volumes_;
  std::size_t volume_count_ = 0;
  bool has_negative_ = false;
  std::span<MeshInstance> instances_;
  std::size_t count_ = 0;
  std::uint32_t steps_ = 0;
  std::uint64_t root_ = 0;
};

}  // namespace plumbline::inline slicer
