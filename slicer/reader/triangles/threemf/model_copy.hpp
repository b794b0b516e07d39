#pragma once
/// A 3MF file in short form, so that its XML is parsed only once.

#include <array>
#include <cstddef>
#include <cstdint>
#include <span>

#include "slicer/core/arena.hpp"
#include "slicer/reader/triangles/threemf/model_parts.hpp"
#include "slicer/reader/triangles/triangle_batch.hpp"
#include "slicer/reader/triangles/vertex_list.hpp"

namespace plumbline::inline slicer {

/// The objects of a file, one after another, as a stream that is read from its beginning: their vertices as VertexList keeps them, and for
/// each corner of a triangle the difference to the number of the corner before, mostly in one or two bytes. Made while the file is read for
/// the first time, when nobody knows yet what is printed.
class ModelCopy {
 public:
  /// @param room  where it is made; empty: nowhere, the copy is never whole
  explicit ModelCopy(std::span<std::byte> room);

  /// @param is_solid  its mesh is printed if the build places it
  void begin_object(const ObjectKey& key, bool is_solid);
  /// @returns false if it can't be copied: there is no room, or vertices follow triangles
  bool add_vertex(const Vec3d& p);
  /// @returns false if there is no room, or a corner has no vertex
  bool add_triangle(const std::array<std::uint64_t, 3>& corners);
  /// Makes no copy after all. The file is then read again, and that reading reports what is wrong with it.
  void give_up() { is_whole_ = false; }
  bool is_whole() const { return is_whole_; }
  bool is_finished() const { return is_whole_ && end_ > 0; }

  /// Completes it: declares its objects in `parts`, and adds a copy of these.
  /// @param bytes  of the file
  /// @returns false if an object is there twice, nested too deeply or printed too often, or if there is no room
  /// @param project  what goes into the summary of each reading
  [[nodiscard]] bool finish(ModelParts& parts, double unit_mm, std::uint64_t bytes, const UnusedSettings& project);

  // After finish():

  /// The places of the file's objects.
  /// @param memory  for the transforms of one object
  [[nodiscard]] Expected<ModelParts> parts(Arena& memory) const;
  /// Passes on all triangles that are printed.
  /// @param parts  of the file
  /// @param done  progress of the reading before
  /// @retval ErrorCode::kCancelled and all of the sink's
  [[nodiscard]] Status deliver(ModelParts& parts, TriangleBatch& batch, double done) const;
  std::uint64_t file_bytes() const { return file_bytes_; }
  const UnusedSettings& project() const { return project_; }

  std::span<const std::byte> bytes() const { return room_.first(used_); }
  /// Follows its bytes to where they have been moved.
  void move_to(std::span<std::byte> place) { room_ = place; }

 private:
  struct alignas(8) Head {
    ObjectKey key;
    bool is_solid = false;
    std::array<double, 3> origin{};
    std::uint64_t vertices = 0;
    std::uint64_t triangles = 0;
    std::uint64_t corner_bytes = 0;  ///< of all triangles
  };
  /// An object and what follows its head.
  struct Object {
    Head head;
    const std::byte* vertices = nullptr;
    const std::byte* corners = nullptr;
  };
  static constexpr std::size_t padded(std::size_t bytes) {
    return (bytes + alignof(Head) - 1) / alignof(Head) * alignof(Head);
  }

  std::byte* take(std::size_t bytes);
  Object object_at(std::size_t& at) const;
  void close_object();

  std::span<std::byte> room_;
  std::size_t used_ = 0;
  bool is_whole_;
  std::size_t head_at_ = 0;
  Head head_;  ///< of the open object, written when it is closed
  bool is_open_ = false;
  std::uint64_t last_corner_ = 0;
  std::size_t end_ = 0;  ///< of the objects; the places follow
  std::size_t places_ = 0;
  std::size_t volumes_ = 0;
  UnusedSettings project_;
  std::uint64_t root_ = 0;
  double unit_mm_ = 1;
  std::uint64_t file_bytes_ = 0;
};

/// Adds the triangles of an object once for each place where the object is printed, with the roles that they have there.
class PlacedTriangles {
 public:
  /// @param parts  after find_instances(mesh); outlives this
  PlacedTriangles(const ModelParts& parts, const ObjectKey& mesh, double unit_mm, TriangleBatch& batch)
      : parts_(parts), mesh_(mesh), unit_mm_(unit_mm), batch_(batch) {}

  /// Call it for each triangle, in order.
  [[nodiscard]] Status add(const Triangle& corners);

 private:
  const ModelParts& parts_;
  ObjectKey mesh_;
  double unit_mm_;
  TriangleBatch& batch_;
  std::uint32_t number_ = 0;
  std::uint32_t end_ = 0;  ///< of the triangles of one role
  VolumeRole role_ = VolumeRole::kSolid;
};

}  // namespace plumbline::inline slicer
