#pragma once
/// Writes point clouds as PLY files.

#include <cstddef>
#include <cstdint>
#include <span>
#include <string>
#include <string_view>

#include "firmware/io/output_file.hpp"
#include "slicer/core/error.hpp"
#include "slicer/reader/stream/scan_point.hpp"

namespace plumbline::firmware {

/// Writes PLY, binary little-endian, float x y z nx ny nz: 24 bytes a point. A file that was not closed by
/// close() is removed, so a scan is complete or absent; pipes and devices stay.
class PlyWriter {
 public:
  /// @param path      replaced if it exists
  /// @param comments  for the header, one line each, without line ends
  /// @param points    how many write() will be given
  /// @retval ErrorCode::kCannotOpen, kCannotWrite  with the file's name and the system's reason
  [[nodiscard]] static Expected<PlyWriter> create(const std::string& path, std::span<const std::string_view> comments,
                                                  std::uint64_t points);
  PlyWriter(PlyWriter&& other) noexcept;
  PlyWriter& operator=(PlyWriter&&) = delete;
  ~PlyWriter();

  /// @retval ErrorCode::kCannotWrite  with the file's name and the system's reason
  [[nodiscard]] Status write(std::span<const ScanPoint> points);

  /// Must be the last call. Asserts that as many points were written as announced.
  /// @retval ErrorCode::kCannotWrite  with the file's name and the system's reason
  [[nodiscard]] Status close();

 private:
  PlyWriter(const std::string& path, OutputFile file, std::uint64_t points);

  std::string path_;  ///< removed unless close() succeeds; empty: nothing to remove
  OutputFile file_;
  std::uint64_t missing_;  ///< points still to come
};

}  // namespace plumbline::firmware
