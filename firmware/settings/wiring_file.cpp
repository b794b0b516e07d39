#include "firmware/settings/wiring_file.hpp"

namespace plumbline::firmware::inline settings {
namespace {

constexpr std::array<std::string_view, 2> kActive = {"high", "low"};  // by LineSettings::active_low
constexpr std::array<std::uint32_t, 2> kScreenBits = {16, 24};
// The smallest screen that the texts fit on; far above any panel for people.
constexpr double kLeastScreenColumns = 320, kLeastScreenRows = 240, kMostScreenSide = 1920;
constexpr auto kOptional = Presence::kOptional;
// Characters: enough for any device, and bounded because messages repeat them.
constexpr double kLongestDevicePath = 255;
constexpr double kLongestName = 63;

template <class SomeThermals, class Visit>
void for_each_sensor(SomeThermals& thermals, Visit&& visit) {
  constexpr std::array kTables = {"lamp_sensor", "resin_sensor", "board_sensor"};  // by TemperatureSite
  for (std::size_t i = 0; i < kTables.size(); ++i) visit(kTables[i], thermals.sensors[i]);
}

template <class SomeThermals, class Visit>
void for_each_fan(SomeThermals& thermals, Visit&& visit) {
  constexpr std::array kTables = {"lamp_fan", "chamber_fan"};  // by Fan
  for (std::size_t i = 0; i < kTables.size(); ++i) visit(kTables[i], thermals.fans[i]);
}

TextSetting path(std::string& value) { return {&value, TextKind::kPath}; }

}  // namespace

void add_wiring_rules(std::vector<SettingRule>& rules, Wiring& wiring) {
  DisplaySettings& display = wiring.display;
  rules.push_back({"display", "card", path(display.card), 1, kLongestDevicePath, "", kOptional});
  rules.push_back({"display", "connector", path(display.connector), 1, kLongestName, "", kOptional});
  rules.push_back({"display", "refresh_hz", &display.refresh_hz, 1, 500, " Hz", kOptional});
  rules.push_back({"display", "plane", &display.plane, 1, 0xFFFFFFFF, "", kOptional});
  rules.push_back({"display", "flip_timeout_ms", &display.flip_timeout_ms, 20, 5000, " ms", kOptional});
  ScreenSettings& screen = wiring.screen;
  rules.push_back({"screen", "columns", &screen.columns, kLeastScreenColumns, kMostScreenSide, " pixels", kOptional});
  rules.push_back({"screen", "rows", &screen.rows, kLeastScreenRows, kMostScreenSide, " pixels", kOptional});
  rules.push_back({"screen", "card", path(screen.card), 1, kLongestDevicePath, "", kOptional});
  rules.push_back({"screen", "connector", path(screen.connector), 1, kLongestName, "", kOptional});
  rules.push_back(
      {"screen", "rotation_deg", NumberChoiceSetting{kRotations, &screen.rotation_deg}, 0, 0, " degrees", kOptional});
  rules.push_back({"screen", "bits", NumberChoiceSetting{kScreenBits, &screen.bits}, 0, 0, "", kOptional});
  rules.push_back({"screen", "touch", path(screen.touch), 1, kLongestDevicePath, "", kOptional});
  for_each_line(wiring, [&](const LineRole& role, LineSettings& line) {
    rules.push_back({role.table, "line", path(line.name), 1, kLongestName, "", kOptional});
    rules.push_back({role.table, "chip", path(line.chip), 1, kLongestName, "", kOptional});
    rules.push_back({role.table, "offset", &line.offset, 0, 1023, "", kOptional});
    rules.push_back({role.table, "active", choice(kActive, line.active_low), 0, 0, "", kOptional});
    rules.push_back({role.table, "bias", choice(kLineBiasWords, line.bias), 0, 0, "", kOptional});
  });
  for_each_sensor(wiring.thermals, [&](std::string_view table, SensorSettings& sensor) {
    rules.push_back({table, "hwmon", path(sensor.hwmon), 1, kLongestName, "", kOptional});
    rules.push_back({table, "channel", &sensor.channel, 1, 64, "", kOptional});
    rules.push_back({table, "thermal_zone", path(sensor.thermal_zone), 1, kLongestName, "", kOptional});
    rules.push_back({table, "file", path(sensor.file), 1, kLongestDevicePath, "", kOptional});
  });
  for_each_fan(wiring.thermals, [&](std::string_view table, FanSettings& fan) {
    rules.push_back({table, "hwmon", path(fan.hwmon), 1, kLongestName, "", kOptional});
    rules.push_back({table, "channel", &fan.channel, 0, 64, "", kOptional});
    rules.push_back({table, "pwm_chip", path(fan.pwm_chip), 1, kLongestName, "", kOptional});
    rules.push_back({table, "period_us", &fan.period_us, 1, 1000000, " us", kOptional});
  });
  rules.push_back({"stick", "port", path(wiring.stick.port), 1, kLongestName, "", kOptional});
  rules.push_back({"watchdog", "device", path(wiring.watchdog.device), 1, kLongestDevicePath, "", kOptional});
  rules.push_back({"watchdog", "timeout_s", &wiring.watchdog.timeout_s, 2, 60, " s", kOptional});
}

std::string check_wiring(const SettingRule& rule, const Wiring& wiring) {
  std::string wrong;
  for_each_line(wiring, [&](const LineRole& role, const LineSettings& line) {
    if (rule.table != role.table) return;
    if (line.name.empty() == line.chip.empty()) {
      wrong = "but a line is given either by line or by chip and offset";
    } else if (line.chip.empty() != (line.offset == LineSettings::kNoOffset)) {
      wrong = "but chip and offset go together";
    }
  });
  for_each_sensor(wiring.thermals, [&](std::string_view table, const SensorSettings& sensor) {
    const int ways = int{!sensor.hwmon.empty()} + int{!sensor.thermal_zone.empty()} + int{!sensor.file.empty()};
    if (rule.table == table && ways != 1)
      wrong = "but a sensor is given by exactly one of hwmon, thermal_zone and file";
  });
  for_each_fan(wiring.thermals, [&](std::string_view table, const FanSettings& fan) {
    if (rule.table == table && fan.hwmon.empty() == fan.pwm_chip.empty()) {
      wrong = "but a fan is given either by hwmon or by pwm_chip";
    }
  });
  if (rule.table == "screen" && (wiring.screen.columns == 0 || wiring.screen.rows == 0)) {
    wrong = "but a screen is given by columns and rows";
  }
  if (rule.table == "watchdog" && wiring.watchdog.device.empty()) wrong = "but a watchdog is given by device";
  return wrong;
}

std::vector<std::string_view> missing_tables(const Wiring& wiring) {
  std::vector<std::string_view> names;
  if (wiring.display.connector.empty()) names.emplace_back("display");
  for_each_line(wiring, [&](const LineRole& role, const LineSettings& line) {
    if (role.required && !line.given()) names.push_back(role.table);
  });
  for_each_sensor(wiring.thermals, [&](std::string_view table, const SensorSettings& sensor) {
    if (!sensor.given()) names.push_back(table);
  });
  return names;
}

}  // namespace plumbline::firmware::inline settings
