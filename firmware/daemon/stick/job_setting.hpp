#pragma once

#include <string_view>

#include "firmware/daemon/stick/stick_job.hpp"
#include "slicer/core/error.hpp"

namespace plumbline::firmware {

/// Changes one setting of a job: the keys of job.toml but `scan` and `profile`, with the same ranges.
/// @param value  a number, a word, true or false; "" sets supports, layer_height and values of the print back to the profile's
/// Setting a size clears scale and fit, and setting one of those clears the size. The same holds for orient and the rotation.
/// @retval ErrorCode::kBadSetting  the key, what was found, what is allowed; nothing has changed
[[nodiscard]] Status set_job_setting(StickJob& job, std::string_view key, std::string_view value);

}  // namespace plumbline::firmware
