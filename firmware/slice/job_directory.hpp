#pragma once
/// The folder that a job's files go to.
///
///   out/layers/00000.png ...   the masks
///   out/preview.png
///   out/coverage.png           of a sliced job: which parts of the surface were scanned
///   out/issues.png             where the checks of the masks have found something
///   out/comparison.png         of a printed part: the part beside what was to be printed, and how far it deviates
///   out/manifest.json          appears last, in one step: a folder that has it holds a complete job
///
/// Nothing here waits until the data is on disk, so a power cut may lose any of it.

#include <cstddef>
#include <cstdint>
#include <span>
#include <string>

#include "firmware/io/output_file.hpp"
#include "firmware/io/text/fixed_text.hpp"
#include "slicer/core/error.hpp"

namespace plumbline::firmware {

enum class JobPicture : std::uint8_t {
  kPreview,     ///< what is to be printed, or was
  kCoverage,    ///< which parts of the surface were scanned
  kIssues,      ///< where the checks of the masks have found something
  kComparison,  ///< of a printed part: the part beside what was to be printed
};

class JobDirectory {
 public:
  /// Creates the folder, its parents and `layers` if missing, and checks that it holds nothing but an older job, complete or
  /// not, which may be replaced. Locks it against other plumbline processes.
  ///
  /// The older job stays until begin(). What open() created is removed with the object unless begin() was called.
  ///
  /// @param path  not empty
  /// @retval ErrorCode::kCannotOpen   the folder can't be made or written to: the path and the reason
  /// @retval ErrorCode::kCannotWrite  it holds other files, one of which the message names, or it is in use
  [[nodiscard]] static Expected<JobDirectory> open(const std::string& path);
  JobDirectory(JobDirectory&& other) noexcept;
  JobDirectory& operator=(JobDirectory&&) = delete;
  ~JobDirectory();

  /// Checks that its file system has room for `bytes`; the older job's files count as free, since they will be replaced.
  /// @param what  that needs them, for the message
  /// @retval ErrorCode::kCannotWrite  it has not; what is needed and what is free
  [[nodiscard]] Status check_room(const char* what, std::uint64_t bytes) const;

  /// Removes the older job's manifest and pictures: from now on the folder holds no complete job. This and all later calls
  /// take no memory from the heap.
  /// @retval ErrorCode::kCannotWrite
  [[nodiscard]] Status begin();

  /// @param layer  0 to 65535
  /// @retval ErrorCode::kCannotOpen, kCannotWrite  path, reason, what to do
  [[nodiscard]] Status write_layer(std::uint32_t layer, std::span<const std::byte> png);
  /// Of its file.
  static const char* name(JobPicture picture);
  [[nodiscard]] Status write_picture(JobPicture picture, std::span<const std::byte> png);

  /// The manifest, under a temporary name until finish().
  [[nodiscard]] Expected<OutputFile> create_manifest();
  /// Closes the manifest, removes the older job's surplus layers, and gives the manifest its name.
  [[nodiscard]] Status finish(OutputFile& manifest);

  /// Removes what was written since begin(), and what was left of the older job.
  void discard();

  const char* path() const { return path_.c_str(); }

 private:
  JobDirectory() = default;
  [[nodiscard]] Status create_folders();
  [[nodiscard]] Status inspect();
  [[nodiscard]] Status inspect_layers();
  [[nodiscard]] Status remove_file(const char* name);
  [[nodiscard]] Status remove_layers(std::uint32_t from);
  FixedPath file_path(const char* name) const;
  FixedPath layer_path(std::uint32_t layer) const;

  FixedPath path_;
  int lock_ = -1;
  bool created_ = false;  ///< the folder is ours
  bool created_layers_ = false;
  bool begun_ = false;
  std::uint32_t older_end_ = 0;    ///< one past the older job's last layer
  std::uint64_t older_bytes_ = 0;  ///< that the older job's layers and pictures take on the disk
  std::uint32_t written_end_ = 0;  ///< one past the last layer written
};

}  // namespace plumbline::firmware
