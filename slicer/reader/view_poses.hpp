#pragma once
/// Where the files of a scan lie in their common frame, as the .conf files of Stanford's scans say.

#include <array>
#include <cstddef>
#include <optional>
#include <span>
#include <string_view>

#include "slicer/reader/records/scan_pose.hpp"
#include "slicer/reader/scan_sources.hpp"

namespace plumbline::inline slicer {

inline constexpr std::size_t kMostPoseBytes = std::size_t{64} * 1024;  ///< of a .conf; some 100 a scan are usual

/// Whether a file is such a .conf, by its name.
bool is_pose_file(std::string_view name);
/// Whether one of a job's files is.
bool has_pose_file(ScanSources sources);

/// The lines "bmesh FILE tx ty tz qx qy qz qw" of a .conf, also "mesh", each give a file's pose; its other lines say nothing here:
///   p' = R^T p + t, where R is the rotation of the quaternion: checked with the views of the bunny, whose .conf is published
class ViewPoses {
 public:
  /// Reads every .conf among the sources.
  /// @param workspace  free again when this returns
  /// @retval ErrorCode::kMalformed   a line that names a scan has no pose, or the file is too large for a .conf
  /// @retval ErrorCode::kBadSetting  a .conf before a scan or without any, one that names none of them, or a scan without a pose or with two
  [[nodiscard]] static Expected<ViewPoses> read(ScanSources sources, std::span<std::byte> workspace);

  std::size_t scans() const { return scans_; }  ///< how many of the sources are scans: those before the first .conf
  /// @returns the identity if there is no .conf
  ScanPose of(std::size_t scan) const { return poses_[scan].value_or(ScanPose()); }

 private:
  Status read_file(ByteSource& conf, ScanSources scans, std::span<std::byte> workspace);

  std::size_t scans_ = 0;
  std::array<std::optional<ScanPose>, kMostScans> poses_;
};

}  // namespace plumbline::inline slicer
