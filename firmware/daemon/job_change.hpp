#pragma once

#include <string_view>

#include "firmware/daemon/daemon_settings.hpp"
#include "firmware/daemon/stick/stick_job.hpp"
#include "slicer/core/error.hpp"

namespace plumbline::firmware {

/// A job with the values of the print that a person has given its profile.
StickJob as_asked(StickJob job, const PrintProfile& profile);

/// Changes a setting of a job: a key of set_job_setting(), `profile`, or `reset`, whose value is "".
/// @param plain  the job before anybody has changed it, to which `reset` goes back
/// @retval ErrorCode::kBadSetting  the errors of set_job_setting() and of DaemonSettings::profile(); an archive has no such setting; or
///     supports are set by hand although they are off. Nothing has changed
[[nodiscard]] Status change_job(StickJob& job, std::string_view key, std::string_view value, const StickJob& plain,
                                const DaemonSettings& daemon);

/// Clears supports set by hand, which hold for one object in one size, orientation and height above the plate.
/// @param before  the job to whose object they belong
/// @returns whether there were any that do not hold any more
bool clear_stale_supports(StickJob& job, const StickJob& before, const DaemonSettings& daemon);

}  // namespace plumbline::firmware
