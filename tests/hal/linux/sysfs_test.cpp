/// Temperatures, fans and sticks on folders that look like sysfs.

#include <gmock/gmock.h>
#include <gtest/gtest.h>
#include <stdlib.h>

#include <filesystem>
#include <fstream>

#include "hal/linux/board_parts.hpp"
#include "hal/linux/stick/stick_volume.hpp"
#include "hal/linux/thermals/thermals.hpp"

namespace plumbline {
namespace {

namespace fs = std::filesystem;
using testing::HasSubstr;

class Sysfs : public testing::Test {
 protected:
  void SetUp() override {
    std::string pattern = (fs::temp_directory_path() / "plumbline-sysfs-XXXXXX").string();
    ASSERT_NE(::mkdtemp(pattern.data()), nullptr);
    root_ = pattern;
    write("class/hwmon/hwmon0/name", "cpu");
    write("class/hwmon/hwmon4/name", "lm75");
    write("class/hwmon/hwmon4/temp1_input", "31250");
    write("class/hwmon/hwmon4/temp2_input", "-4500");
    write("class/hwmon/hwmon4/pwm1", "255");
    write("class/hwmon/hwmon4/pwm1_enable", "2");
    write("class/hwmon/hwmon4/fan1_input", "1200");
    write("class/hwmon/hwmon4/pwm2", "0");
    write("class/thermal/thermal_zone0/type", "soc-thermal");
    write("class/thermal/thermal_zone0/temp", "48000");
    write("w1/temperature", "22187");
  }
  void TearDown() override { fs::remove_all(root_); }

  void write(const std::string& path, const std::string& text) const {
    fs::create_directories((root_ / path).parent_path());
    std::ofstream(root_ / path) << text << '\n';
  }
  std::string read(const std::string& path) const {
    std::string text;
    std::ifstream file(root_ / path);
    std::getline(file, text);
    return text;
  }
  ThermalSettings settings() const {
    ThermalSettings settings;
    settings.sensors[0] = {.hwmon = "lm75", .channel = 1, .thermal_zone = "", .file = ""};
    settings.sensors[1] = {.hwmon = "", .channel = 1, .thermal_zone = "", .file = (root_ / "w1/temperature").string()};
    settings.sensors[2] = {.hwmon = "", .channel = 1, .thermal_zone = "soc-thermal", .file = ""};
    settings.fans[0] = {.hwmon = "lm75", .channel = 1, .pwm_chip = "", .period_us = 40};
    return settings;
  }
  std::unique_ptr<LinuxThermals> open(const ThermalSettings& settings) {
    auto devices = LinuxThermals::open(settings, root_.string());
    if (!devices) {
      ADD_FAILURE() << devices.error().message();
      return nullptr;
    }
    return std::make_unique<LinuxThermals>(std::move(*devices), interlock_);
  }

  fs::path root_;
  Interlock interlock_;
};

TEST_F(Sysfs, FindsSensorsByNameAndReadsThemEachTime) {
  const auto thermals = open(settings());
  ASSERT_TRUE(thermals);
  EXPECT_DOUBLE_EQ(thermals->temperature(TemperatureSite::kLamp)->value(), 31.25);
  EXPECT_DOUBLE_EQ(thermals->temperature(TemperatureSite::kResin)->value(), 22.187);
  EXPECT_DOUBLE_EQ(thermals->temperature(TemperatureSite::kBoard)->value(), 48.0);
  write("class/hwmon/hwmon4/temp1_input", "66000");
  EXPECT_DOUBLE_EQ(thermals->temperature(TemperatureSite::kLamp)->value(), 66.0);
}

TEST_F(Sysfs, ListsWhatABoardFileCanName) {
  write("class/drm/card1-HDMI-A-1/status", "connected");
  write("class/drm/card1-HDMI-A-1/modes", "540x2560\n540x2560\n640x480");
  write("class/drm/version", "drm 1.1.0");
  write("class/pwm/pwmchip0/npwm", "2");
  write("bus/w1/devices/28-0316/temperature", "21500");
  write("bus/usb/devices/1-1.2/manufacturer", "SanDisk");
  write("bus/usb/devices/1-1.2/product", "Cruzer");
  write("bus/usb/devices/1-1.2:1.0/product", "an interface");
  write("class/watchdog/watchdog0/identity", "Broadcom BCM2835 Watchdog timer");
  write("dev/watchdog", "");
  write("dev/watchdog0", "");
  write("dev/input/by-path/platform-i2c-event", "");
  write("dev/serial/by-id/usb-FTDI-port0", "");
  std::vector<std::string> found;
  for (const BoardPart& part : list_board_parts(root_.string(), (root_ / "dev").string())) {
    if (part.kind == "line") continue;  // of the machine that runs the test
    std::string text = part.kind + ": " + part.answer + (part.detail.empty() ? "" : "; " + part.detail);
    for (std::size_t at; (at = text.find(root_.string())) != std::string::npos;) text.erase(at, root_.string().size());
    found.push_back(text);
  }
  EXPECT_THAT(
      found,
      testing::ElementsAre(
          "connector: HDMI-A-1; connected, modes 540x2560, 640x480, of /dev/dri/card1", "fan: hwmon lm75 1",
          "fan: hwmon lm75 2", "fan: pwm pwmchip0 0; 2 channels, from 0 on", "sensor: hwmon lm75 1; 31 degrees C now",
          "sensor: hwmon lm75 2; -4 degrees C now", "sensor: zone soc-thermal; 48 degrees C now",
          "sensor: file /bus/w1/devices/28-0316/temperature; 21 degrees C now", "stick port: 1-1.2; SanDisk Cruzer",
          "watchdog: /dev/watchdog0; Broadcom BCM2835 Watchdog timer",
          "touch panel: /dev/input/by-path/platform-i2c-event; or another input",
          "serial port: /dev/serial/by-id/usb-FTDI-port0"));
  EXPECT_TRUE(std::all_of(found.begin(), found.end(), [](const auto& text) { return text.size() < 200; }));
}

TEST_F(Sysfs, ReportsASensorWithoutAPlausibleReadingAsDead) {
  const auto thermals = open(settings());
  ASSERT_TRUE(thermals);
  for (const char* text : {"", "no", "200000", "12x"}) {
    write("class/hwmon/hwmon4/temp1_input", text);
    const auto read = thermals->temperature(TemperatureSite::kLamp);
    ASSERT_FALSE(read) << text;
    EXPECT_EQ(read.error().code(), ErrorCode::kSensorDead) << text;
  }
}

TEST_F(Sysfs, NamesAMissingSensorAndThoseThatExist) {
  auto wrong = settings();
  wrong.sensors[0].hwmon = "ds18b20";
  const auto opened = LinuxThermals::open(wrong, root_.string());
  ASSERT_FALSE(opened);
  EXPECT_EQ(opened.error().code(), ErrorCode::kBadSetting);
  EXPECT_THAT(opened.error().message(), testing::AllOf(HasSubstr("the lamp's sensor"), HasSubstr("ds18b20"),
                                                       HasSubstr("lm75"), HasSubstr("cpu")));
}

TEST_F(Sysfs, TakesAFanFromTheKernelAndSetsItsSpeed) {
  const auto thermals = open(settings());
  ASSERT_TRUE(thermals);
  EXPECT_EQ(read("class/hwmon/hwmon4/pwm1_enable"), "1");
  EXPECT_EQ(read("class/hwmon/hwmon4/pwm1").substr(0, 1), "0");
  ASSERT_TRUE(thermals->set_fan(Fan::kLamp, 0.5));
  EXPECT_EQ(read("class/hwmon/hwmon4/pwm1"), "128");
  ASSERT_TRUE(thermals->set_fan(Fan::kLamp, 7));
  EXPECT_EQ(read("class/hwmon/hwmon4/pwm1"), "255");
  EXPECT_EQ(thermals->fan_health(Fan::kLamp), FanHealth::kOk) << "it has just been turned on";
}

TEST_F(Sysfs, IgnoresAMissingFan) {
  const auto thermals = open(settings());
  ASSERT_TRUE(thermals);
  EXPECT_TRUE(thermals->set_fan(Fan::kChamber, 1));
  EXPECT_EQ(thermals->fan_health(Fan::kChamber), FanHealth::kNotMonitored);
}

TEST_F(Sysfs, SetsThePeriodOfAPwmChipAndEnablesIt) {
  write("class/pwm/pwmchip0/pwm1/duty_cycle", "0");
  write("class/pwm/pwmchip0/pwm1/period", "0");
  write("class/pwm/pwmchip0/pwm1/enable", "0");
  auto with_pwm = settings();
  with_pwm.fans[1] = {.hwmon = "", .channel = 1, .pwm_chip = "pwmchip0", .period_us = 40};
  const auto thermals = open(with_pwm);
  ASSERT_TRUE(thermals);
  ASSERT_TRUE(thermals->set_fan(Fan::kChamber, 0.25));
  EXPECT_EQ(read("class/pwm/pwmchip0/pwm1/period"), "40000");
  EXPECT_EQ(read("class/pwm/pwmchip0/pwm1/duty_cycle"), "10000");
  EXPECT_EQ(read("class/pwm/pwmchip0/pwm1/enable"), "1");
}

TEST_F(Sysfs, NamesAStickByItsPlaceOnTheBus) {
  const std::uint8_t ports[] = {1, 4, 2};
  EXPECT_EQ(usb_place(1, ports, 3), "1-1.4.2");
  EXPECT_EQ(usb_place(2, ports, 1), "2-1");
}

TEST_F(Sysfs, ReadsAStickIdentity) {
  write("usb/1-1/idVendor", "0781");
  write("usb/1-1/idProduct", "5581");
  write("usb/1-1/manufacturer", "SanDisk");
  write("usb/1-1/product", std::string(200, 'u'));
  const auto identity = read_identity((root_ / "usb/1-1").string());
  EXPECT_EQ(identity.vendor_id, 0x0781);
  EXPECT_EQ(identity.product_id, 0x5581);
  EXPECT_STREQ(identity.maker.data(), "SanDisk");
  EXPECT_EQ(std::string(identity.product.data()), std::string(identity.product.size() - 1, 'u'))
      << "truncated, with a final 0";
  EXPECT_STREQ(identity.serial.data(), "") << "not every stick has one";
}

TEST_F(Sysfs, PrefersAStickFirstPartitionToTheWholeMedium) {
  const std::string device = (root_ / "usb/1-1").string();
  EXPECT_TRUE(block_devices(device).empty()) << "the kernel has not found its medium yet";
  const std::string block = "usb/1-1/1-1:1.0/host0/target0:0:0/0:0:0:0/block/";
  write(block + "sdb/size", "0");
  EXPECT_TRUE(block_devices(device).empty()) << "a card reader without a card";
  write(block + "sdb/size", "196608");
  EXPECT_THAT(block_devices(device), testing::ElementsAre("/dev/sdb"));
  for (const char* number : {"10", "2"}) {
    write(block + "sdb/sdb" + number + "/partition", number);
    write(block + "sdb/sdb" + number + "/size", "1000");
  }
  write(block + "sdb/sdb5/partition", "5");
  write(block + "sdb/sdb5/size", "2");  // an extended partition, which holds the tenth
  fs::create_directories(root_ / (block + "sdb/queue"));
  EXPECT_THAT(block_devices(device), testing::ElementsAre("/dev/sdb2", "/dev/sdb10", "/dev/sdb"));
}

TEST_F(Sysfs, WaitsUntilTheKernelHasLookedForPartitions) {
  const std::string device = (root_ / "usb/1-1").string();
  const std::string udev = (root_ / "udev").string();
  const std::string block = "usb/1-1/1-1:1.0/host0/target0:0:0/0:0:0:0/block/";
  write(block + "sda/size", "196608");
  write(block + "sda/dev", "8:0");
  EXPECT_THAT(block_devices(device, udev), testing::ElementsAre("/dev/sda"))
      << "without udev partitions are not waited for";
  write("udev/b8:16", "I:1");
  EXPECT_TRUE(block_devices(device, udev).empty()) << "or else the whole medium would be tried first";
  write(block + "sda/sda1/partition", "1");
  write(block + "sda/sda1/size", "1000");
  EXPECT_TRUE(block_devices(device, udev).empty()) << "more partitions may follow";
  write("udev/b8:0", "I:2");
  EXPECT_THAT(block_devices(device, udev), testing::ElementsAre("/dev/sda1", "/dev/sda"));
  // In a reader with two cards, one may be ready before the other.
  write(block + "sdb/size", "500");
  write(block + "sdb/dev", "8:32");
  EXPECT_THAT(block_devices(device, udev), testing::ElementsAre("/dev/sda1", "/dev/sda"));
}

}  // namespace
}  // namespace plumbline
