#pragma once

#include <span>

#include "firmware/child/scan_request.hpp"
#include "firmware/daemon/daemon_settings.hpp"
#include "firmware/daemon/stick/stick_job.hpp"
#include "firmware/settings/print_profile.hpp"
#include "hal/stick_port.hpp"
#include "slicer/core/error.hpp"

namespace plumbline::firmware {

/// What the slicing child is asked for, to print a job from a stick. Runs the checks of the print that don't depend on its height, before
/// the minutes that slicing takes.
/// @param scan     the job's files, open
/// @param profile  the job's
/// @retval ErrorCode::kBadSetting  an archive that is part of a scan or has settings, the profile's supports, and any error of plan_print()
[[nodiscard]] Expected<ScanRequest> stick_request(const StickJob& job, std::span<const StickFile> scan,
                                                  const PrintProfile& profile, const DaemonSettings& daemon);

}  // namespace plumbline::firmware
