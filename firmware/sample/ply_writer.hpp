#pragma once
/// Point clouds into PLY files.

#include <array>
#include <cstddef>
#include <cstdio>
#include <memory>
#include <span>
#include <string>
#include <string_view>

#include "slicer/core/error.hpp"
#include "slicer/reader/scan_point.hpp"

namespace plumbline {

/// Writes PLY, binary little-endian, float x y z nx ny nz: 24 bytes a point. A file that has not been closed with
/// close() is removed again, so that a scan is whole or absent.
class PlyWriter {
 public:
  /// @param path      replaced if it exists
  /// @param comments  for the header, one line each, without line ends
  /// @param points    how many write() is going to bring
  /// @retval ErrorCode::kCannotOpen, kCannotWrite  with the file's name and the system's reason
  [[nodiscard]] static Expected<PlyWriter> create(const std::string& path, std::span<const std::string_view> comments,
                                                  std::uint64_t points);
  PlyWriter(PlyWriter&&) = default;
  PlyWriter& operator=(PlyWriter&&) = delete;
  ~PlyWriter();

  /// @retval ErrorCode::kCannotWrite  with the file's name and the system's reason
  [[nodiscard]] Status write(std::span<const ScanPoint> points);

  /// The last call. Asserts that as many points have come as were promised.
  /// @retval ErrorCode::kCannotWrite  with the file's name and the system's reason
  [[nodiscard]] Status close();

 private:
  struct CloseFile {
    void operator()(std::FILE* file) const { std::fclose(file); }
  };
  PlyWriter(const std::string& path, std::uint64_t points) : path_(path), missing_(points) {}
  [[nodiscard]] Status put(const void* bytes, std::size_t size);

  std::string path_;
  std::unique_ptr<std::FILE, CloseFile> file_;
  std::uint64_t missing_;  ///< points still to come
};

}  // namespace plumbline
