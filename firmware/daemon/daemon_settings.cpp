#include "firmware/daemon/daemon_settings.hpp"

#include "firmware/daemon/stick/stick_job.hpp"

namespace plumbline::firmware {

Expected<PrintProfile> DaemonSettings::profile(const std::string& name) const {
  auto profile = read_print_profile(name.empty() ? machine.profile : name, board_path);
  if (!profile) return tl::unexpected<Error>(as_setting_error(profile.error()));
  return profile;
}

}  // namespace plumbline::firmware
