#pragma once
/// The files of a mesh, read as often as needed.

#include <array>
#include <optional>

#include "slicer/core/arena.hpp"
#include "slicer/core/progress.hpp"
#include "slicer/reader/reread_source.hpp"
#include "slicer/reader/scan_sources.hpp"
#include "slicer/reader/triangles/mesh_reader.hpp"

namespace plumbline {

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

  /// Reads all files from start to end.
  /// @param each  called after each file
  template <class Each>
  [[nodiscard]] Status read(TriangleSink& sink, VertexList& vertices, std::span<std::byte> workspace, Each each) {
    for (std::size_t i = 0; i < count_; ++i) {
      PLUMBLINE_TRY(files_[i]->rewind());
      file_ = i;
      const auto summary = read_mesh(*files_[i], sink, vertices, workspace);
      PLUMBLINE_TRY(summary);
      each(*summary);
    }
    return {};
  }

  /// Goes back to the beginning of all files.
  [[nodiscard]] Status rewind();
  /// The files as a scan's.
  std::array<ByteSource*, kMostScans> pointers();
  std::size_t count() const { return count_; }
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
};

}  // namespace plumbline
