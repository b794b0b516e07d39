#include "firmware/settings/wiring_file.hpp"

#include <algorithm>

namespace plumbline {
namespace {

constexpr std::array<std::string_view, 2> kActive = {"high", "low"};
constexpr std::array<std::string_view, 4> kBias = {"as-is", "disabled", "pull-up", "pull-down"};
constexpr auto kOptional = Presence::kOptional;
constexpr double kLongestPath = 255;
constexpr double kLongestName = 63;

template <class Wiring, class Visit>
void for_each_wire(Wiring& wiring, Visit&& visit) {
  visit("lamp_line", wiring.lamp);
  visit("cover_line", wiring.cover);
  visit("step_line", wiring.step);
  visit("direction_line", wiring.direction);
  visit("enable_line", wiring.enable);
  visit("end_stop_line", wiring.end_stop);
  visit("start_button", wiring.start);
  visit("pause_button", wiring.pause);
  visit("cancel_button", wiring.cancel);
  constexpr std::array kLights = {"ready_light", "printing_light", "attention_light", "fault_light"};
  for (std::size_t i = 0; i < kLights.size(); ++i) visit(kLights[i], wiring.lights[i]);
  visit("buzzer", wiring.buzzer);
}

template <class Wiring, class Visit>
void for_each_sensor(Wiring& wiring, Visit&& visit) {
  constexpr std::array kSensors = {"lamp_sensor", "resin_sensor", "board_sensor"};
  for (std::size_t i = 0; i < kSensors.size(); ++i) visit(kSensors[i], wiring.sensors[i]);
}

template <class Wiring, class Visit>
void for_each_fan(Wiring& wiring, Visit&& visit) {
  constexpr std::array kFans = {"lamp_fan", "chamber_fan"};
  for (std::size_t i = 0; i < kFans.size(); ++i) visit(kFans[i], wiring.fans[i]);
}

TextSetting path(std::string& value) { return {&value, TextKind::kPath}; }

}  // namespace

void add_wiring_rules(std::vector<SettingRule>& rules, WiringFile& wiring) {
  rules.push_back({"display", "card", path(wiring.card), 1, kLongestPath, "", kOptional});
  rules.push_back({"display", "connector", path(wiring.connector), 1, kLongestName, "", kOptional});
  rules.push_back({"display", "refresh_hz", &wiring.refresh_hz, 1, 500, " Hz", kOptional});
  rules.push_back({"display", "plane", &wiring.plane, 1, 0xFFFFFFFF, "", kOptional});
  rules.push_back({"display", "flip_timeout_ms", &wiring.flip_timeout_ms, 20, 5000, " ms", kOptional});
  for_each_wire(wiring, [&](std::string_view table, WireFile& wire) {
    rules.push_back({table, "line", path(wire.line), 1, kLongestName, "", kOptional});
    rules.push_back({table, "chip", path(wire.chip), 1, kLongestName, "", kOptional});
    rules.push_back({table, "offset", &wire.offset, 0, 1023, "", kOptional});
    rules.push_back({table, "active", choice(kActive, wire.active), 0, 0, "", kOptional});
    rules.push_back({table, "bias", choice(kBias, wire.bias), 0, 0, "", kOptional});
  });
  for_each_sensor(wiring, [&](std::string_view table, SensorFile& sensor) {
    rules.push_back({table, "hwmon", path(sensor.hwmon), 1, kLongestName, "", kOptional});
    rules.push_back({table, "channel", &sensor.channel, 1, 64, "", kOptional});
    rules.push_back({table, "thermal_zone", path(sensor.thermal_zone), 1, kLongestName, "", kOptional});
    rules.push_back({table, "file", path(sensor.file), 1, kLongestPath, "", kOptional});
  });
  for_each_fan(wiring, [&](std::string_view table, FanFile& fan) {
    rules.push_back({table, "hwmon", path(fan.hwmon), 1, kLongestName, "", kOptional});
    rules.push_back({table, "channel", &fan.channel, 0, 64, "", kOptional});
    rules.push_back({table, "pwm_chip", path(fan.pwm_chip), 1, kLongestName, "", kOptional});
    rules.push_back({table, "period_us", &fan.period_us, 1, 1000000, " us", kOptional});
  });
  rules.push_back({"stick", "port", path(wiring.stick_port), 1, kLongestName, "", kOptional});
  rules.push_back({"stick", "mount_point", path(wiring.mount_point), 1, kLongestPath, "", kOptional});
}

std::string check_wiring(const SettingRule& rule, const WiringFile& wiring) {
  std::string wrong;
  for_each_wire(wiring, [&](std::string_view table, const WireFile& wire) {
    if (rule.table != table) return;
    const bool has_offset = wire.offset != WireFile::kNoOffset;
    if (wire.line.empty() == wire.chip.empty()) {
      wrong = "but a line is given by line, or by chip and offset";
    } else if (has_offset == wire.chip.empty()) {
      wrong = "but chip and offset are given together";
    }
  });
  for_each_sensor(wiring, [&](std::string_view table, const SensorFile& sensor) {
    const int ways = int{!sensor.hwmon.empty()} + int{!sensor.thermal_zone.empty()} + int{!sensor.file.empty()};
    if (rule.table == table && ways != 1) wrong = "but a sensor is given by one of hwmon, thermal_zone and file";
  });
  for_each_fan(wiring, [&](std::string_view table, const FanFile& fan) {
    if (rule.table == table && fan.hwmon.empty() == fan.pwm_chip.empty()) {
      wrong = "but a fan is given by hwmon or by pwm_chip";
    }
  });
  return wrong;
}

std::vector<std::string_view> WiringFile::missing() const {
  std::vector<std::string_view> names;
  if (connector.empty()) names.emplace_back("display");
  for_each_wire(*this, [&](std::string_view table, const WireFile& wire) {
    constexpr std::array<std::string_view, 4> kNeeded = {"lamp_line", "step_line", "direction_line", "end_stop_line"};
    if (!wire.given() && std::find(kNeeded.begin(), kNeeded.end(), table) != kNeeded.end()) names.push_back(table);
  });
  for_each_sensor(*this, [&](std::string_view table, const SensorFile& sensor) {
    if (!sensor.given()) names.push_back(table);
  });
  return names;
}

}  // namespace plumbline
