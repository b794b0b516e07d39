#pragma once
/// What to print from a stick: the job in job.toml, the only scan on it, or the scan that the user chooses.

#include <array>
#include <cstdint>
#include <optional>
#include <string>
#include <string_view>

#include "firmware/io/fixed_text.hpp"
#include "firmware/settings/job_settings.hpp"
#include "hal/stick_port.hpp"
#include "slicer/core/error.hpp"

namespace plumbline {

struct StickJob : JobSettings {
  std::string scan;     ///< name on the stick
  std::string profile;  ///< name of a profile; empty: the printer's
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

struct StickScan {
  FixedText<256> name;
  std::uint64_t bytes = 0;
};

/// The scans in a stick's top folder, by name.
struct StickScans {
  static constexpr std::size_t kMost = 64;
  std::array<StickScan, kMost> list;
  std::size_t count = 0;
  std::size_t left_out = 0;      ///< scans for which there was no room
  FixedText<256> job_file;       ///< its name on the stick; empty: there is none
  std::optional<Error> foreign;  ///< about a file that is sliced for another printer
};

/// Whether a file is offered as a scan, by its name: its ending is one of scan_endings.hpp, and it is
/// not a text that comes with scans, such as README.txt.
bool is_scan_name(std::string_view name);

/// @retval ErrorCode::kBadSetting  a job.toml that is not a file; two of them; or a name that looks like a misspelt job.toml's
/// @retval ErrorCode::kCannotOpen  without a job.toml: something with a scan's name that is not a file
/// @retval the errors of StickMount::for_each_file()
[[nodiscard]] Expected<StickScans> list_scans(const StickMount& mount);

}  // namespace plumbline
