#include "slicer/mesh/mesh_files.hpp"

#include <algorithm>

namespace plumbline {

Expected<MeshFiles> MeshFiles::open(ScanSources sources, Arena& arena) {
  MeshFiles files;
  for (ByteSource* source : sources) {
    auto file = RereadSource::open(*source, arena);
    PLUMBLINE_TRY(file);
    files.files_[files.count_++].emplace(*file);
  }
  return files;
}

Expected<MeshHint> MeshFiles::hint(std::span<std::byte> workspace) {
  MeshHint least = MeshHint::kTriangles;
  for (std::size_t i = 0; i < count_; ++i) {
    files_[i]->peek();
    const auto hint = hint_of(*files_[i], workspace);
    PLUMBLINE_TRY(files_[i]->rewind());
    PLUMBLINE_TRY(hint);
    least = std::min(least, *hint);
  }
  return least;
}

Status MeshFiles::keep_all(Arena& arena) {
  for (std::size_t i = 0; i < count_; ++i) PLUMBLINE_TRY(files_[i]->keep_all(arena));
  return {};
}

Status MeshFiles::rewind() {
  for (std::size_t i = 0; i < count_; ++i) PLUMBLINE_TRY(files_[i]->rewind());
  return {};
}

std::array<ByteSource*, kMostScans> MeshFiles::pointers() {
  std::array<ByteSource*, kMostScans> pointers{};
  for (std::size_t i = 0; i < count_; ++i) pointers[i] = &*files_[i];
  return pointers;
}

std::optional<std::uint64_t> MeshFiles::largest() const {
  std::uint64_t largest = 0;
  for (std::size_t i = 0; i < count_; ++i) {
    const auto size = files_[i]->size();
    if (!size) return std::nullopt;
    largest = std::max(largest, *size);
  }
  return largest;
}

}  // namespace plumbline
