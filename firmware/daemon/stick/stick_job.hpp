#pragma once
/// What to print from a stick: the job in job.toml, the only scan on it, or the scan that the user chooses.

#include <array>
#include <cstdint>
#include <optional>
#include <string>
#include <string_view>
#include <vector>

#include "firmware/io/text/fixed_text.hpp"
#include "firmware/settings/job_settings.hpp"
#include "hal/stick_port.hpp"
#include "slicer/core/error.hpp"

namespace plumbline::firmware {

struct StickJob : JobSettings {
  std::vector<std::string>
      scans;                  ///< names on the stick of a scan's files, 1 to kMostScans, or of one folder that has them
  std::string profile;        ///< name of a profile; empty: the printer's
  std::string title() const;  ///< "bust.ply", or "front.ply and 2 more"; printable
  bool operator==(const StickJob&) const = default;
};

/// Words of its settings, by the value of the enumeration; those of supports by whether there are any.
inline constexpr std::array<std::string_view, 5> kUnitWords = {"mm", "cm", "m", "in", "auto"};
inline constexpr std::array<std::string_view, 2> kSupportWords = {"none", "auto"};
inline constexpr std::array<std::string_view, 3> kBaseWords = {"auto", "none", "flat"};
inline constexpr std::array<std::string_view, 3> kAsWords = {"auto", "points", "mesh"};
static_assert(static_cast<int>(ReadAs::kAuto) == 0 && static_cast<int>(ReadAs::kPoints) == 1 &&
              static_cast<int>(ReadAs::kMesh) == 2);
static_assert(static_cast<int>(Units::kMillimetres) == 0 && static_cast<int>(Units::kAuto) == 4);
static_assert(static_cast<int>(BaseChoice::kAuto) == 0 && static_cast<int>(BaseChoice::kNone) == 1 &&
              static_cast<int>(BaseChoice::kFlat) == 2);

inline constexpr std::string_view kJobFile = "job.toml";  ///< in any case

/// The same error as ErrorCode::kBadSetting: if a settings file can't be read or parsed, the scan is not to blame.
Error as_setting_error(const Error& error);

/// @param path  for messages
/// @retval ErrorCode::kBadSetting  any error of parse_settings()
[[nodiscard]] Expected<StickJob> parse_stick_job(std::string_view text, std::string_view path);

/// Names the files of a job whose scan is a folder. Other jobs stay as they are.
/// @retval the errors of FolderScans::paths() and StickMount::for_each_file()
[[nodiscard]] Status find_files(StickJob& job, const StickMount& mount);

/// @returns the files of a job's scan, in their order
/// @retval ErrorCode::kBadSetting  more than kMostScans files
/// @retval the errors of StickMount::open()
[[nodiscard]] Expected<std::vector<StickFile>> open_scan(const StickJob& job, const StickMount& mount);

}  // namespace plumbline::firmware
