#include "firmware/sample/ply_writer.hpp"

#include <algorithm>
#include <bit>
#include <cassert>
#include <cerrno>
#include <cstring>

namespace plumbline {
namespace {

constexpr std::size_t kPointBytes = 24;

void put_float(unsigned char* to, double value) {
  const auto bits = std::bit_cast<std::uint32_t>(static_cast<float>(value));
  for (unsigned i = 0; i < 4; ++i) to[i] = static_cast<unsigned char>(bits >> (8 * i));
}

}  // namespace

Expected<PlyWriter> PlyWriter::create(const std::string& path, std::span<const std::string_view> comments,
                                      std::uint64_t points) {
  PlyWriter writer(path, points);
  std::FILE* file = std::fopen(path.c_str(), "wb");
  if (!file) return fail(ErrorCode::kCannotOpen, "%s: cannot create: %s", path.c_str(), std::strerror(errno));
  writer.file_.reset(file);
  std::string header = "ply\nformat binary_little_endian 1.0\n";
  for (const auto comment : comments) header.append("comment ").append(comment).append("\n");
  header.append("element vertex ").append(std::to_string(points)).append("\n");
  for (const char* name : {"x", "y", "z", "nx", "ny", "nz"}) {
    header.append("property float ").append(name).append("\n");
  }
  header.append("end_header\n");
  PLUMBLINE_TRY(writer.put(header.data(), header.size()));
  return writer;
}

PlyWriter::~PlyWriter() {
  if (!file_) return;
  file_.reset();
  std::remove(path_.c_str());
}

Status PlyWriter::put(const void* bytes, std::size_t size) {
  if (std::fwrite(bytes, 1, size, file_.get()) == size) return {};
  return fail(ErrorCode::kCannotWrite, "%s: cannot write: %s", path_.c_str(), std::strerror(errno));
}

Status PlyWriter::write(std::span<const ScanPoint> points) {
  assert(points.size() <= missing_);
  std::array<unsigned char, 256 * kPointBytes> block;
  while (!points.empty()) {
    const std::size_t count = std::min(points.size(), block.size() / kPointBytes);
    for (std::size_t i = 0; i < count; ++i) {
      const ScanPoint& p = points[i];
      unsigned char* to = block.data() + i * kPointBytes;
      for (const double value : {p.x, p.y, p.z, double{p.nx}, double{p.ny}, double{p.nz}}) {
        put_float(to, value);
        to += 4;
      }
    }
    PLUMBLINE_TRY(put(block.data(), count * kPointBytes));
    points = points.subspan(count);
    missing_ -= count;
  }
  return {};
}

Status PlyWriter::close() {
  assert(missing_ == 0);
  // A full disk may show only when the buffers are flushed.
  const int flushed = std::fflush(file_.get());
  const int reason = errno;
  const int closed = std::fclose(file_.release());
  if (flushed == 0 && closed == 0) return {};
  const int last = flushed != 0 ? reason : errno;
  std::remove(path_.c_str());
  return fail(ErrorCode::kCannotWrite, "%s: cannot write: %s", path_.c_str(), std::strerror(last));
}

}  // namespace plumbline
