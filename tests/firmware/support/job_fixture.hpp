#pragma once
/// Shared by the tests of jobs: a temporary folder, and a scan whose shape is known.

#include <gtest/gtest.h>

#include <cmath>
#include <cstdlib>
#include <filesystem>
#include <fstream>
#include <iterator>
#include <span>
#include <stdexcept>
#include <string>
#include <string_view>
#include <vector>

#include "firmware/sample/ply_writer.hpp"
#include "firmware/slice/slice_job.hpp"

namespace plumbline::firmware {

/// A folder for one test, removed at the end with its contents.
class TemporaryFolder {
 public:
  TemporaryFolder() {
    std::string pattern = (std::filesystem::temp_directory_path() / "plumbline-XXXXXX").string();
    if (::mkdtemp(pattern.data()) == nullptr) throw std::runtime_error("no temporary folder: " + pattern);
    path_ = pattern;
  }
  ~TemporaryFolder() {
    std::error_code ignored;
    std::filesystem::remove_all(path_, ignored);
  }
  TemporaryFolder(const TemporaryFolder&) = delete;
  TemporaryFolder& operator=(const TemporaryFolder&) = delete;

  std::string operator/(std::string_view name) const { return (path_ / name).string(); }

 private:
  std::filesystem::path path_;
};

inline std::string read_text(const std::string& path) {
  std::ifstream file(path, std::ios::binary);
  return {std::istreambuf_iterator<char>(file), std::istreambuf_iterator<char>()};
}

inline void write_text(const std::string& path, std::string_view text) {
  std::ofstream(path, std::ios::binary).write(text.data(), static_cast<std::streamsize>(text.size()));
}

inline void write_scan(const std::string& path, const std::vector<ScanPoint>& cloud) {
  auto writer = PlyWriter::create(path, {}, cloud.size());
  ASSERT_TRUE(writer.has_value()) << writer.error().message();
  ASSERT_TRUE(writer->write(cloud).has_value());
  ASSERT_TRUE(writer->close().has_value());
}

/// A clean sphere round the origin, evenly scanned (Fibonacci lattice), with outward normals or normals of length 0.
inline std::vector<ScanPoint> sphere_scan(std::uint32_t points, double radius_mm, bool normals = true) {
  std::vector<ScanPoint> cloud(points);
  constexpr double kGoldenAngle = 2.39996322972865332;
  for (std::uint32_t i = 0; i < points; ++i) {
    const double z = 1 - 2 * (i + 0.5) / points;
    const double r = std::sqrt(1 - z * z);
    const double x = r * std::cos(kGoldenAngle * i);
    const double y = r * std::sin(kGoldenAngle * i);
    const double length = normals ? 1 : 0;
    cloud[i] = {radius_mm * x,
                radius_mm * y,
                radius_mm * z,
                static_cast<float>(length * x),
                static_cast<float>(length * y),
                static_cast<float>(length * z)};
  }
  return cloud;
}

inline void write_sphere_scan(const std::string& path, std::uint32_t points, double radius_mm, bool normals = true) {
  write_scan(path, sphere_scan(points, radius_mm, normals));
}

/// A printer small enough for tests: 40 x 30 x 50 mm in pixels of 0.1 mm; its rows do not end at a byte.
inline PrinterVolume small_printer() {
  return {.columns = 403, .rows = 300, .pitch_x_mm = 0.1F, .pitch_y_mm = 0.1F, .travel_mm = 50};
}

inline SliceJobSettings sphere_job(const TemporaryFolder& folder) {
  SliceJobSettings settings;
  settings.scan_paths = {folder / "sphere.ply"};
  settings.output_path = folder / "out";
  settings.printer_name = "small";
  settings.slice.placement.printer = small_printer();
  settings.slice.placement.layer_height_mm = 0.1F;
  settings.slice.threads = 2;
  return settings;
}

}  // namespace plumbline::firmware
