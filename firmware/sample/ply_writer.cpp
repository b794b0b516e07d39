#include "firmware/sample/ply_writer.hpp"

#include <algorithm>
#include <array>
#include <bit>
#include <cassert>
#include <filesystem>
#include <system_error>
#include <utility>

namespace plumbline::firmware {
namespace {

constexpr std::size_t kPointBytes = 24;

void put_float(unsigned char* to, double value) {
  const auto bits = std::bit_cast<std::uint32_t>(static_cast<float>(value));
  for (unsigned i = 0; i < 4; ++i) to[i] = static_cast<unsigned char>(bits >> (8 * i));
}

}  // namespace

PlyWriter::PlyWriter(const std::string& path, OutputFile file, std::uint64_t points)
    : path_(path), file_(std::move(file)), missing_(points) {}

PlyWriter::PlyWriter(PlyWriter&& other) noexcept
    : path_(std::exchange(other.path_, {})), file_(std::move(other.file_)), missing_(other.missing_) {}

PlyWriter::~PlyWriter() {
  std::error_code ignored;
  if (!path_.empty() && std::filesystem::is_regular_file(path_, ignored)) std::filesystem::remove(path_, ignored);
}

Expected<PlyWriter> PlyWriter::create(const std::string& path, std::span<const std::string_view> comments,
                                      std::uint64_t points) {
  auto file = OutputFile::create(path.c_str());
  PLUMBLINE_TRY(file);
  PlyWriter writer(path, std::move(*file), points);
  std::string header = "ply\nformat binary_little_endian 1.0\n";
  for (const auto comment : comments) header.append("comment ").append(comment).append("\n");
  header.append("element vertex ").append(std::to_string(points)).append("\n");
  for (const char* name : {"x", "y", "z", "nx", "ny", "nz"}) {
    header.append("property float ").append(name).append("\n");
  }
  header.append("end_header\n");
  PLUMBLINE_TRY(writer.file_.write(header));
  return writer;
}

Status PlyWriter::write(std::span<const ScanPoint> points) {
  assert(points.size() <= missing_);
  std::array<unsigned char, 1024 * kPointBytes> block;
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
    PLUMBLINE_TRY(file_.write(std::as_bytes(std::span(block).first(count * kPointBytes))));
    points = points.subspan(count);
    missing_ -= count;
  }
  return {};
}

Status PlyWriter::close() {
  assert(missing_ == 0);
  PLUMBLINE_TRY(file_.close());
  path_.clear();
  return {};
}

}  // namespace plumbline::firmware
