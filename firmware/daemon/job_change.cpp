#include "firmware/daemon/job_change.hpp"

#include <string>
#include <utility>

#include "firmware/archive/layer_archive.hpp"
#include "firmware/daemon/stick/job_setting.hpp"
#include "firmware/messages/printer_code.hpp"

namespace plumbline::firmware {
namespace {

/// The settings of a job that decide where its object lies on the plate.
JobSettings placing(JobSettings job) {
  job.layer_height = 0;
  job.values = {};
  job.supports = {};
  return job;
}

/// @retval ErrorCode::kBadSetting  they are off, too
Expected<SupportSettings> supports_of(const StickJob& job, const DaemonSettings& daemon) {
  const auto profile = daemon.profile(job.profile);
  PLUMBLINE_TRY(profile);
  const auto supports = job.supports.over(profile->supports_enable, profile->supports);
  PLUMBLINE_TRY(supports);
  if (!*supports) return fail(ErrorCode::kBadSetting, "supports are off");
  return **supports;
}

Status set_any(StickJob& job, std::string_view key, std::string_view value, const StickJob& plain,
               const DaemonSettings& daemon) {
  if (key == "reset") {
    if (!value.empty()) return fail(ErrorCode::kBadSetting, "reset: allowed is \"\", which resets all settings");
    job = plain;
    return {};
  }
  if (key == "profile") {
    PLUMBLINE_TRY(daemon.profile(std::string(value)));
    const auto name_of = [&](std::string_view name) { return name.empty() ? daemon.machine.profile : name; };
    if (name_of(value) != name_of(job.profile)) job.profile = value;
    return {};
  }
  if (is_archive_name(job.scans[0]) && find_print_field(key) == nullptr) {
    return telling(
        Told(PrinterCode::kArchiveSettings, {}, job.title()),
        fail(ErrorCode::kBadSetting,
             "%s: is sliced already, so only its profile, exposures, lifts and waits can be set", job.title().c_str()));
  }
  return set_job_setting(job, key, value);
}

}  // namespace

StickJob as_asked(StickJob job, const PrintProfile& profile) {
  for (const PrintField& field : kPrintFields) {
    if (!field.can_be_changed()) continue;
    const std::size_t i = index_of(field.key);
    job.values[i].reset();
    if (profile.sources[i] == ValueSource::kPerson) job.values[i] = value_of(profile, field);
  }
  return job;
}

Status change_job(StickJob& job, std::string_view key, std::string_view value, const StickJob& plain,
                  const DaemonSettings& daemon) {
  StickJob changed = job;
  PLUMBLINE_TRY(set_any(changed, key, value, plain, daemon));
  if (changed.supports.has_places() && changed.supports.places != job.supports.places) {
    PLUMBLINE_TRY(supports_of(changed, daemon));
  }
  job = std::move(changed);
  return {};
}

bool clear_stale_supports(StickJob& job, const StickJob& before, const DaemonSettings& daemon) {
  if (!job.supports.has_places() || job.supports.places != before.supports.places) return false;
  const auto now = supports_of(job, daemon), was = supports_of(before, daemon);
  const bool as_high = now && was && now->stand == was->stand && lift_mm(*now) == lift_mm(*was);
  if (as_high && placing(before) == placing(job)) return false;
  job.supports.places = {};
  return true;
}

}  // namespace plumbline::firmware
