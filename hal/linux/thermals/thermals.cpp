#include "hal/linux/thermals/thermals.hpp"

#include <cerrno>
#include <cmath>
#include <cstring>
#include <filesystem>
#include <fstream>

namespace plumbline::inline hal::inline linux_board {
namespace {

namespace fs = std::filesystem;

constexpr std::int64_t kFullHwmonDuty = 255;  // pwm1 of a hwmon chip at full speed: Linux, hwmon/sysfs-interface

std::string first_line(const fs::path& path) {
  std::string text;
  std::getline(std::ifstream(path) >> std::ws, text);
  return text;
}

/// The folder below `root` whose file `file` contains `name`.
Expected<std::string> find_named(const fs::path& root, const char* file, const std::string& name) {
  std::string others;
  std::error_code problem;
  for (const auto& entry : fs::directory_iterator(root, problem)) {
    const std::string here = first_line(entry.path() / file);
    if (here == name) return entry.path().string();
    if (!here.empty()) others += (others.empty() ? "" : ", ") + here;
  }
  return fail(ErrorCode::kBadSetting, "%s: no device is called %s; this board has %s", root.c_str(), name.c_str(),
              others.empty() ? "none" : others.c_str());
}

/// Writes a channel's number to "export", which makes sysfs create its folder.
Expected<std::string> export_pwm(const std::string& chip, std::uint32_t channel) {
  const std::string folder = chip + "/pwm" + std::to_string(channel);
  if (fs::exists(folder)) return folder;
  auto exporter = std::ofstream(chip + "/export");
  exporter << channel << std::flush;
  if (!exporter || !fs::exists(folder)) {
    return fail(ErrorCode::kCannotOpen,
                "%s: can't use channel %u: it doesn't exist, another driver has it, or permission is missing",
                chip.c_str(), channel);
  }
  return folder;
}

}  // namespace

Expected<std::string> find_sensor(const SensorSettings& settings, const std::string& sysfs) {
  if (!settings.file.empty()) return settings.file;
  if (!settings.thermal_zone.empty()) {
    auto zone = find_named(sysfs + "/class/thermal", "type", settings.thermal_zone);
    if (!zone) return zone;
    return *zone + "/temp";
  }
  auto chip = find_named(sysfs + "/class/hwmon", "name", settings.hwmon);
  if (!chip) return chip;
  return *chip + "/temp" + std::to_string(settings.channel) + "_input";
}

Expected<std::string> find_fan(const FanSettings& settings, const std::string& sysfs) {
  if (settings.hwmon.empty()) {
    const std::string chip = sysfs + "/class/pwm/" + settings.pwm_chip;
    if (!fs::exists(chip)) return fail(ErrorCode::kBadSetting, "%s: this board has no such PWM chip", chip.c_str());
    return chip + "/export";
  }
  auto chip = find_named(sysfs + "/class/hwmon", "name", settings.hwmon);
  if (!chip) return chip;
  return *chip + "/pwm" + std::to_string(settings.channel);
}

Expected<LinuxFan> LinuxFan::open(const FanSettings& settings, const std::string& sysfs) {
  const auto place = find_fan(settings, sysfs);
  PLUMBLINE_TRY(place);
  if (settings.hwmon.empty()) {
    const auto channel = export_pwm(sysfs + "/class/pwm/" + settings.pwm_chip, settings.channel);
    PLUMBLINE_TRY(channel);
    const std::int64_t full = std::int64_t{settings.period_us} * 1000;
    auto duty = NumberFile::open(*channel + "/duty_cycle", NumberFile::Access::kReadWrite);
    PLUMBLINE_TRY(duty);
    auto period = NumberFile::open(*channel + "/period", NumberFile::Access::kReadWrite);
    PLUMBLINE_TRY(period);
    auto enable = NumberFile::open(*channel + "/enable", NumberFile::Access::kReadWrite);
    PLUMBLINE_TRY(enable);
    // The kernel refuses a period below the duty cycle, so set that to 0 first. On a new channel this fails, but there it is 0.
    static_cast<void>(duty->write(0));
    if (!period->write(full) || !duty->write(0) || !enable->write(1)) {
      return fail(ErrorCode::kCannotOpen, "%s: %s", channel->c_str(), std::strerror(errno));
    }
    return LinuxFan(std::move(*duty), full, std::nullopt);
  }
  const std::string chip = fs::path(*place).parent_path().string();
  const std::string number = std::to_string(settings.channel);
  auto duty = NumberFile::open(*place, NumberFile::Access::kReadWrite);
  PLUMBLINE_TRY(duty);
  // 1 is manual control. Chips without automatic control have no such file.
  if (auto mode = NumberFile::open(chip + "/pwm" + number + "_enable", NumberFile::Access::kReadWrite)) {
    if (!mode->write(1)) return fail(ErrorCode::kCannotOpen, "%s: %s", chip.c_str(), std::strerror(errno));
  }
  if (!duty->write(0)) return fail(ErrorCode::kCannotOpen, "%s: %s", chip.c_str(), std::strerror(errno));
  std::optional<NumberFile> tachometer;
  if (auto file = NumberFile::open(chip + "/fan" + number + "_input", NumberFile::Access::kRead)) {
    tachometer.emplace(std::move(*file));
  }
  return LinuxFan(std::move(*duty), kFullHwmonDuty, std::move(tachometer));
}

bool LinuxFan::set(double duty) noexcept {
  const bool on = duty > 0;
  if (on && !on_) turned_on_at_ = monotonic_now();
  on_ = on;
  return duty_.write(std::llround(duty * static_cast<double>(full_)));
}

FanHealth LinuxFan::health() const noexcept {
  constexpr nanoseconds kSpinUp = std::chrono::seconds(2);  // as Thermals::fan_health() promises
  if (!tachometer_) return FanHealth::kNotMonitored;
  if (!on_ || monotonic_now() < turned_on_at_ + kSpinUp) return FanHealth::kOk;
  return tachometer_->read().value_or(0) > 0 ? FanHealth::kOk : FanHealth::kStalled;
}

Expected<LinuxThermals::Devices> LinuxThermals::open(const ThermalSettings& settings, const std::string& sysfs) {
  Devices devices;
  for (std::size_t i = 0; i < kTemperatureSiteCount; ++i) {
    const std::string name = "the " + std::string(to_string(static_cast<TemperatureSite>(i))) + "'s sensor";
    const auto path = find_sensor(settings.sensors[i], sysfs);
    if (!path) return tl::unexpected<Error>(path.error().with_prefix(name));
    auto file = NumberFile::open(*path, NumberFile::Access::kRead);
    if (!file) return tl::unexpected<Error>(file.error().with_prefix(name));
    devices.sensors[i].emplace(std::move(*file));
  }
  for (std::size_t i = 0; i < kFanCount; ++i) {
    if (!settings.fans[i].given()) continue;
    const std::string name = "the " + std::string(to_string(static_cast<Fan>(i))) + " fan";
    auto fan = LinuxFan::open(settings.fans[i], sysfs);
    if (!fan) return tl::unexpected<Error>(fan.error().with_prefix(name));
    devices.fans[i].emplace(std::move(*fan));
  }
  return devices;
}

Expected<Celsius> LinuxThermals::do_temperature(TemperatureSite site) const {
  const auto& sensor = devices_.sensors[static_cast<std::size_t>(site)];
  const auto read = sensor ? sensor->read() : std::nullopt;
  if (!read) {
    const auto where = to_string(site);
    return fail(ErrorCode::kSensorDead, "the %.*s's temperature sensor does not answer:\tcheck its plug",
                static_cast<int>(where.size()), where.data());
  }
  return Celsius(static_cast<double>(*read) / 1000);
}

Status LinuxThermals::do_set_fan(Fan fan, double duty) {
  auto& device = devices_.fans[static_cast<std::size_t>(fan)];
  if (device && !device->set(duty)) {
    const auto which = to_string(fan);
    return fail(ErrorCode::kDeviceTimeout, "the %.*s fan can't be set: %s", static_cast<int>(which.size()),
                which.data(), std::strerror(errno));
  }
  return {};
}

FanHealth LinuxThermals::do_fan_health(Fan fan) const {
  const auto& device = devices_.fans[static_cast<std::size_t>(fan)];
  return device ? device->health() : FanHealth::kNotMonitored;
}

}  // namespace plumbline::inline hal::inline linux_board
