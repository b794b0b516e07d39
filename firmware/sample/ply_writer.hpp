#pragma once
/// Point clouds into PLY files.

#include <cstddef>
#include <cstdint>
#include <span>
#include <string>
#include <string_view>

#include "firmware/io/output_file.hpp"
#include "slicer/core/error.hpp"
#include "slicer/reader/stream/scan_point.hpp"

namespace plumbline {

/// Writes PLY, binary little-endian, float x y z nx ny nz: 24 bytes a point. A file that close() did not
/// finish is removed again, so that a scan is whole or absent; what is not a regular file (a pipe, a device) stays.
class PlyWriter {
 public:
  /// @param path      replaced if it exists
  /// @param comments  for the header, one line each, without line ends
  /// @param points    how many write() is going to bring
  /// @retval ErrorCode::kCannotOpen, kCannotWrite  with the file's name and the system's reason
  [[nodiscard]] static Expected<PlyWriter> create(const std::string& path, std::span<const std::string_view> comments,
                                                  std::uint64_t points);
  PlyWriter(PlyWriter&& other) noexcept;
  PlyWriter& operator=(PlyWriter&&) = delete;
  ~PlyWriter();

  /// @retval ErrorCode::kCannotWrite  with the file's name and the system's reason
  [[nodiscard]] Status write(std::span<const ScanPoint> points);

  /// The last call. Asserts that as many points have come as were promised.
  /// @retval ErrorCode::kCannotWrite  with the file's name and the system's reason
  [[nodiscard]] Status close();

 private:
  PlyWriter(const std::string& path, OutputFile file, std::uint64_t points);

  std::string path_;  ///< to be removed unless close() succeeds; empty where there is nothing to remove
  OutputFile file_;
  std::uint64_t missing_;  ///< points still to come
};

}  // namespace plumbline
