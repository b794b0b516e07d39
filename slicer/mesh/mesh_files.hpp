#pragma once
/// The files of a mesh, read as often as needed.

#include <array>
#include <optional>

#include "slicer/core/arena.hpp"
#include "slicer/core/progress.hpp"
#include "slicer/reader/reread_source.hpp"
#include "slicer/reader/scan_sources.hpp"
#include "slicer/reader/triangles/mesh_reader.hpp"

namespace plumbline::inline slicer {

/// A job's files, which may be meshes or scans.
class MeshFiles {
 public:
  /// @param sources  1 to kMostScans, each at its beginning
  /// @param arena    see RereadSource::open()
  [[nodiscard]] static Expected<MeshFiles> open(ScanSources sources, Arena& arena);

  MeshFiles(const MeshFiles&) = delete;
  MeshFiles(MeshFiles&&) = default;
  MeshFiles& operator=(const MeshFiles&) = delete;

  /// Looks at the beginning of each file.
  /// @param workspace  kReaderWorkspace bytes
  /// @returns the least sure hint of all files
  [[nodiscard]] Expected<MeshHint> hint(std::span<std::byte> workspace);

  // After hint(): whether some files are of the format that is read in mm whatever unit it is in, 3MF, and whether some are not.
  bool some_in_mm() const { return packed_ > 0; }
  bool some_in_any_unit() const { return packed_ < count_; }

  /// Makes sure that all files can be read several times.
  [[nodiscard]] Status keep_all(Arena& arena);

  /// Reads all files from start to end, or the copy of the only one.
  /// @param each  called after each file
  template <class Each>
  [[nodiscard]] Status read(TriangleSink& sink, VertexList& vertices, std::span<std::byte> workspace, Each each) {
    ModelCopy none({});
    return read(sink, vertices, workspace, each, none);
  }
  /// The same.
  /// @param copy  read_mesh() makes it
  template <class Each>
  [[nodiscard]] Status read(TriangleSink& sink, VertexList& vertices, std::span<std::byte> workspace, Each each,
                            ModelCopy& copy) {
    for (std::size_t i = 0; i < count_; ++i) {
      if (!copy_) PLUMBLINE_TRY(files_[i]->rewind());
      file_ = i;
      const auto summary =
          copy_ ? read_mesh(*copy_, sink, workspace) : read_mesh(*files_[i], sink, vertices, workspace, copy);
      PLUMBLINE_TRY(summary);
      each(*summary);
    }
    return {};
  }

  /// After hint(): whether the next reading is worth a copy. Of several files none is copied.
  bool wants_copy() const { return !copy_ && count_ == 1 && packed_ == 1; }
  /// From now on the copy is read instead of the file.
  /// @param copy   finished; its bytes may lie in what was given back to the bottom of the arena
  /// @param arena  takes the bytes to its bottom
  [[nodiscard]] Status keep(const ModelCopy& copy, Arena& arena);
  std::size_t copied_bytes() const { return copy_ ? copy_end_ - copy_begin_ : 0; }  ///< of the arena
  /// The file is read again from now on. Gives the memory back unless something was taken since.
  void drop_copy(Arena& arena);
  /// How many vertices the next reading has to keep.
  /// @param most  that it keeps without a copy
  std::uint64_t vertices_kept(std::uint64_t most) const { return copy_ ? 0 : most; }

  /// Goes back to the beginning of all files.
  [[nodiscard]] Status rewind();
  /// The files as a scan's.
  std::array<ByteSource*, kMostScans> pointers();
  /// Bytes of the largest file; none: unknown, or a file is packed (see hint())
  std::optional<std::uint64_t> largest() const;

  /// Where the current file's progress lies in that of all files.
  /// @param fraction  of the current file
  double progress(double fraction) const {
    return (static_cast<double>(file_) + fraction) / static_cast<double>(count_);
  }

 private:
  MeshFiles() = default;

  std::size_t count_ = 0;
  std::size_t file_ = 0;    ///< that is read
  std::size_t packed_ = 0;  ///< how many are MeshHint::kPackedMesh
  std::array<std::optional<RereadSource>, kMostScans> files_;
  std::optional<ModelCopy> copy_;  ///< of the only file
  std::size_t copy_begin_ = 0;     ///< marks of the arena's bottom
  std::size_t copy_end_ = 0;
};

}  // namespace plumbline::inline slicer
