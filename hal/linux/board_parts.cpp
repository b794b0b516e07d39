#include "hal/linux/board_parts.hpp"

#include <algorithm>
#include <filesystem>
#include <fstream>
#include <tuple>

#include "hal/linux/gpio/gpio_line.hpp"

namespace plumbline::inline hal::inline linux_board {
namespace {

namespace fs = std::filesystem;

/// A folder of a sick driver must not fill the memory or the screen.
constexpr std::size_t kMostEntries = 256;
constexpr std::size_t kMostModes = 6;
constexpr std::size_t kLongestWord = 63;

std::string first_line(const fs::path& path) {
  std::string text;
  std::getline(std::ifstream(path), text);
  if (text.size() > kLongestWord) text.resize(kLongestWord);
  return text;
}

/// The names in a folder, sorted so that hwmon10 comes after hwmon9.
std::vector<std::string> names_in(const fs::path& folder) {
  std::vector<std::string> names;
  std::error_code ignored;
  for (const auto& entry : fs::directory_iterator(folder, ignored)) {
    if (names.size() == kMostEntries) break;
    names.push_back(entry.path().filename().string());
  }
  const auto key = [](const std::string& name) { return std::tuple(name.substr(0, 3), name.size(), name); };
  std::sort(names.begin(), names.end(), [&](const auto& a, const auto& b) { return key(a) < key(b); });
  return names;
}

/// "tmp102" has temp1_input, temp2_input: the number between.
std::string channel_of(const std::string& name, const std::string& begin, const std::string& end) {
  if (!name.starts_with(begin) || !name.ends_with(end) || name.size() <= begin.size() + end.size()) return {};
  const std::string number = name.substr(begin.size(), name.size() - begin.size() - end.size());
  return number.find_first_not_of("0123456789") == std::string::npos ? number : std::string();
}

class Listing {
 public:
  Listing(fs::path sysfs, fs::path dev) : sysfs_(std::move(sysfs)), dev_(std::move(dev)) {}

  std::vector<BoardPart> list() {
    list_connectors();
    list_lines();
    list_fans();
    list_sensors();
    list_usb();
    for (const std::string& name : names_in(dev_)) {
      if (!channel_of(name, "watchdog", "").empty()) {
        add("watchdog", (dev_ / name).string(), first_line(sysfs_ / "class/watchdog" / name / "identity"));
      }
    }
    for (const std::string& name : names_in(dev_ / "input/by-path")) {
      if (name.ends_with("-event")) add("touch panel", (dev_ / "input/by-path" / name).string(), "or another input");
    }
    for (const std::string& name : names_in(dev_ / "serial/by-id")) {
      add("serial port", (dev_ / "serial/by-id" / name).string(), "");
    }
    return std::move(parts_);
  }

 private:
  void add(std::string kind, std::string answer, std::string detail) {
    parts_.push_back({std::move(kind), std::move(answer), std::move(detail)});
  }

  void list_connectors() {
    for (const std::string& name : names_in(sysfs_ / "class/drm")) {
      // card0-HDMI-A-1
      const std::size_t dash = name.find('-');
      if (!name.starts_with("card") || dash == std::string::npos) continue;
      const fs::path folder = sysfs_ / "class/drm" / name;
      std::string detail = first_line(folder / "status");
      std::ifstream modes(folder / "modes");
      std::vector<std::string> seen;
      for (std::string mode; seen.size() <= kMostModes && std::getline(modes, mode);) {
        if (mode.size() > kLongestWord || std::find(seen.begin(), seen.end(), mode) != seen.end()) continue;
        seen.push_back(mode);
        detail += seen.size() > kMostModes ? ", ..." : (seen.size() == 1 ? ", modes " : ", ") + mode;
      }
      add("connector", name.substr(dash + 1), detail + ", of /dev/dri/" + name.substr(0, dash));
    }
  }

  void list_lines() {
    for (const GpioChip& chip : list_gpio_chips()) {
      for (const GpioChip::Line& line : chip.lines) {
        const std::string place = chip.label + " " + std::to_string(line.offset);
        add("line", line.name.empty() ? place : line.name,
            (line.name.empty() ? chip.name : chip.name + ", " + place) +
                (line.holder.empty() ? "" : ", held by " + line.holder));
      }
    }
  }

  void list_fans() {
    for_each_hwmon([this](const std::string& chip, const std::string& file) {
      if (const auto number = channel_of(file, "pwm", ""); !number.empty())
        add("fan", "hwmon " + chip + " " + number, "");
    });
    for (const std::string& name : names_in(sysfs_ / "class/pwm")) {
      const std::string channels = first_line(sysfs_ / "class/pwm" / name / "npwm");
      add("fan", "pwm " + name + " 0", (channels.empty() ? "?" : channels) + " channels, from 0 on");
    }
  }

  void list_sensors() {
    const auto degrees = [](const fs::path& file) {
      const std::string thousandths = first_line(file);
      return thousandths.size() > 3 ? thousandths.substr(0, thousandths.size() - 3) + " degrees C now" : std::string();
    };
    for_each_hwmon([&](const std::string& chip, const std::string& file) {
      if (const auto number = channel_of(file, "temp", "_input"); !number.empty()) {
        add("sensor", "hwmon " + chip + " " + number, degrees(hwmon_ / file));
      }
    });
    for (const std::string& name : names_in(sysfs_ / "class/thermal")) {
      const fs::path folder = sysfs_ / "class/thermal" / name;
      const std::string type = first_line(folder / "type");
      if (name.starts_with("thermal_zone") && !type.empty()) add("sensor", "zone " + type, degrees(folder / "temp"));
    }
    for (const std::string& name : names_in(sysfs_ / "bus/w1/devices")) {
      const fs::path file = sysfs_ / "bus/w1/devices" / name / "temperature";
      std::error_code ignored;
      if (fs::exists(file, ignored)) add("sensor", "file " + file.string(), degrees(file));
    }
  }

  void list_usb() {
    for (const std::string& name : names_in(sysfs_ / "bus/usb/devices")) {
      // 1-1.2 is a device, 1-1.2:1.0 its interface, usb1 a controller.
      if (name.find('-') == std::string::npos || name.find(':') != std::string::npos) continue;
      const fs::path folder = sysfs_ / "bus/usb/devices" / name;
      add("stick port", name, first_line(folder / "manufacturer") + " " + first_line(folder / "product"));
    }
  }

  template <class Visit>
  void for_each_hwmon(Visit&& visit) {
    for (const std::string& folder : names_in(sysfs_ / "class/hwmon")) {
      hwmon_ = sysfs_ / "class/hwmon" / folder;
      const std::string chip = first_line(hwmon_ / "name");
      if (chip.empty()) continue;
      for (const std::string& file : names_in(hwmon_)) visit(chip, file);
    }
  }

  fs::path sysfs_, dev_;
  fs::path hwmon_;  ///< of the visit
  std::vector<BoardPart> parts_;
};

}  // namespace

std::vector<BoardPart> list_board_parts(const std::string& sysfs, const std::string& dev) {
  return Listing(sysfs, dev).list();
}

}  // namespace plumbline::inline hal::inline linux_board
