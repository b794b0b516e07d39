#pragma once
/// Real scans, in a folder beside the repository. Where it is missing, their tests are skipped; in CI a skip fails.

#include <filesystem>
#include <fstream>
#include <iterator>
#include <string>

namespace plumbline::testing {

inline std::filesystem::path shared_scan(const std::string& name) {
  return std::filesystem::path(PLUMBLINE_SOURCE_DIR) / ".." / "shared" / "scans" / name;
}

inline std::string content_of(const std::filesystem::path& path) {
  std::ifstream file(path, std::ios::binary);
  return {std::istreambuf_iterator<char>(file), std::istreambuf_iterator<char>()};
}

}  // namespace plumbline::testing
