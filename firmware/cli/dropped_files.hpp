#pragma once

#include <cstdint>
#include <optional>
#include <string>

namespace plumbline::firmware {

/// A folder that people drop files into, as a stick: plugged in while it has files, and again when they have changed.
class DroppedFiles {
 public:
  /// @param folder  exists
  /// @param link    the simulated stick: a link to the folder, while it is plugged in
  DroppedFiles(std::string folder, std::string link);
  ~DroppedFiles() { pull(); }
  DroppedFiles(const DroppedFiles&) = delete;
  DroppedFiles& operator=(const DroppedFiles&) = delete;

  /// Call it a few times a second. Files that still change are being copied, so it waits for two looks that see the same.
  /// @param reading  the printer reads the stick: it stays in
  void look(bool reading);

 private:
  /// Names, sizes and times of the files; none: there is no file.
  std::optional<std::uint64_t> signature() const;
  void plug();
  void pull();

  std::string folder_, link_;
  std::optional<std::uint64_t> seen_, plugged_;
};

}  // namespace plumbline::firmware
