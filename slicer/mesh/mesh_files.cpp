#include "slicer/mesh/mesh_files.hpp"

#include <algorithm>
#include <array>
#include <cstring>
#include <string_view>

#include "slicer/reader/formats/format_probe.hpp"

namespace plumbline::inline slicer {
namespace {

/// Whether a scan is read twice: an E57 says at its end where its points are, a 3MF where its
/// objects stand, and splats are surveyed first.
Expected<bool> is_read_twice(RereadSource& file) {
  std::array<std::byte, RereadSource::kHeadBytes> head{};
  std::size_t filled = 0;
  file.peek();
  while (filled < head.size()) {
    const auto got = file.read(std::span(head).subspan(filled));
    PLUMBLINE_TRY(got);
    if (*got == 0) break;
    filled += *got;
  }
  PLUMBLINE_TRY(file.rewind());
  const std::string_view text(reinterpret_cast<const char*>(head.data()), filled);
  return text.starts_with(kE57Signature) || text.starts_with(kZipSignature) ||
         (text.starts_with("ply") && text.find(" scale_0") != std::string_view::npos);
}

}  // namespace

Expected<MeshFiles> MeshFiles::open(ScanSources sources, Arena& arena) {
  MeshFiles files;
  for (ByteSource* source : sources) {
    auto file = RereadSource::open(*source, arena);
    PLUMBLINE_TRY(file);
    RereadSource& kept = files.files_[files.count_++].emplace(*file);
    if (!kept.is_pipe()) continue;
    const auto twice = is_read_twice(kept);
    PLUMBLINE_TRY(twice);
    if (*twice) PLUMBLINE_TRY(kept.keep_all(arena));
  }
  return files;
}

Expected<MeshHint> MeshFiles::hint(std::span<std::byte> workspace) {
  MeshHint least = MeshHint::kTriangles;
  packed_ = 0;
  for (std::size_t i = 0; i < count_; ++i) {
    files_[i]->peek();
    const auto hint = hint_of(*files_[i], workspace);
    PLUMBLINE_TRY(files_[i]->rewind());
    PLUMBLINE_TRY(hint);
    packed_ += *hint == MeshHint::kPackedMesh ? 1 : 0;
    least = std::min(least, *hint);
  }
  return least;
}

Status MeshFiles::keep_all(Arena& arena) {
  for (std::size_t i = 0; i < count_; ++i) PLUMBLINE_TRY(files_[i]->keep_all(arena));
  return {};
}

Status MeshFiles::keep(const ModelCopy& copy, Arena& arena) {
  copy_begin_ = arena.bottom_mark();
  const auto bytes = copy.bytes();
  const auto place = arena.take_bottom<std::byte>(bytes.size(), "mesh");
  PLUMBLINE_TRY(place);
  std::memmove(place->data(), bytes.data(), bytes.size());
  copy_end_ = arena.bottom_mark();
  copy_.emplace(copy).move_to(*place);
  return {};
}

void MeshFiles::drop_copy(Arena& arena) {
  if (copy_ && arena.bottom_mark() == copy_end_) arena.release_bottom(copy_begin_);
  copy_.reset();
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
  if (packed_ > 0) return std::nullopt;
  std::uint64_t largest = 0;
  for (std::size_t i = 0; i < count_; ++i) {
    const auto size = files_[i]->size();
    if (!size) return std::nullopt;
    largest = std::max(largest, *size);
  }
  return largest;
}

}  // namespace plumbline::inline slicer
