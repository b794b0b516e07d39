#include "hal/linux/examination.hpp"

#include <linux/capability.h>
#include <sys/resource.h>
#include <sys/stat.h>
#include <unistd.h>

#include <cerrno>
#include <cstdio>
#include <cstring>
#include <fstream>

#include "hal/linux/events/real_time.hpp"
#include "hal/linux/gpio/gpio_line.hpp"
#include "hal/linux/machine.hpp"

namespace plumbline::inline hal::inline linux_board {
namespace {

using Verdict = MachineFinding::Verdict;

constexpr const char* kAddKeys = "add it: board/README.md has the keys";

class Examination {
 public:
  explicit Examination(const LinuxSettings& settings) : settings_(settings) {}

  std::vector<MachineFinding> run() {
    check_lines();
    check_keeper();
    check_watchdog();
    check_panel();
    check_screen();
    check_sensors();
    check_fans();
    check_stick();
    check_permissions();
    return std::move(findings_);
  }

 private:
  void add(Verdict verdict, std::string what, std::string found, std::string advice = "") {
    findings_.push_back({verdict, std::move(what), std::move(found), std::move(advice)});
  }

  void check_lines() {
    LineRegistry registry;
    for_each_line(settings_.wiring, [&](const LineRole& role, const LineSettings& line) {
      const std::string use = role.use;
      // "the lamp's line", but "the stage's step line".
      const std::string what = use + (use.find("'s ") == std::string::npos ? "'s line" : " line");
      const std::string missing = "the board file has no [" + std::string(role.table) + "]";
      if (line.given()) return check_line(role, line, what, registry);
      if (role.required) {
        add(Verdict::kWrong, what, missing, kAddKeys);
      } else if (&line == &settings_.wiring.cover) {
        add(Verdict::kPoor, what, missing + ": opening the cover does not turn the lamp off",
            "fit a switch and add [cover_line]");
      }
    });
  }

  void check_line(const LineRole& role, const LineSettings& line, const std::string& what, LineRegistry& registry) {
    const auto place = find_line(line, role.use);
    if (!place) {
      return add(Verdict::kWrong, what, place.error().message(), "correct the board file or the permissions");
    }
    const std::string found = place->chip + " line " + std::to_string(place->offset);
    const auto claimed = registry.claim(*place, role.use);
    const auto holder = holder_of(*place);
    if (!claimed) {
      add(Verdict::kWrong, what, claimed.error().message(), "give each its own line");
    } else if (!holder) {
      add(Verdict::kWrong, what, holder.error().message(), "check the permissions and the chip's driver");
    } else if (holder->empty() || *holder == "plumbline") {
      add(Verdict::kGood, what, found + (holder->empty() ? "" : ", held by a running plumbline"));
    } else {
      add(Verdict::kWrong, what, found + ", held by " + *holder, "end that program or use another line");
    }
  }

  void check_keeper() {
    if (::access(settings_.keeper.c_str(), X_OK) == 0) {
      add(Verdict::kGood, "the lamp's keeper", settings_.keeper);
    } else {
      add(Verdict::kWrong, "the lamp's keeper", settings_.keeper + ": " + std::strerror(errno),
          "install plumbline-keeper beside plumbline: only the keeper lights the lamp");
    }
  }

  /// Does not open it: that would start it.
  void check_watchdog() {
    const std::string& device = settings_.wiring.watchdog.device;
    if (device.empty()) {
      add(Verdict::kPoor, "the watchdog",
          "the board file has no [watchdog]: if the board hangs, the lamp stays as it is",
          "add [watchdog] if the board has one: ls /dev/watchdog*");
      return;
    }
    struct stat file {};
    const std::string folder = settings_.sysfs + "/class/watchdog/" + device.substr(device.rfind('/') + 1);
    std::string identity;
    std::getline(std::ifstream(folder + "/identity"), identity);
    if (::stat(device.c_str(), &file) != 0) {
      add(Verdict::kWrong, "the watchdog", device + ": " + std::strerror(errno),
          "correct [watchdog] or load its driver");
    } else if (!S_ISCHR(file.st_mode)) {
      add(Verdict::kWrong, "the watchdog", device + " is no device", "correct [watchdog]");
    } else if (::access(device.c_str(), W_OK) != 0) {
      add(Verdict::kWrong, "the watchdog", device + ": " + std::strerror(errno),
          "let plumbline's user write it, with a udev rule");
    } else {
      add(Verdict::kGood, "the watchdog", device + (identity.empty() ? "" : ", " + identity));
    }
  }

  void check_panel() {
    if (const auto layout = settings_.panel.check(); !layout) {
      add(Verdict::kWrong, "the panel", layout.error().message(), "correct [panel] in the board file");
      return;
    }
    if (settings_.wiring.display.connector.empty()) {
      add(Verdict::kWrong, "the panel", "the board file has no connector in [display]", kAddKeys);
      return;
    }
    const auto found =
        KmsPanel::examine(settings_.wiring.display, settings_.panel.mode_width(), settings_.panel.mode_height());
    if (found) {
      add(Verdict::kGood, "the panel",
          settings_.wiring.display.connector + " of " + found->card + ", " + found->mode +
              (found->atomic ? ", atomic" : ", without atomic requests"));
    } else {
      add(Verdict::kWrong, "the panel", found.error().message(),
          "correct [display], or check cable, driver and permissions");
    }
  }

  void check_screen() {
    const ScreenSettings& screen = settings_.wiring.screen;
    if (!screen.given()) return;
    const ScreenLayout layout = LinuxStatusScreen::layout_of(screen);
    const auto found = KmsScreen::examine(screen, layout.sent_columns(), layout.sent_rows());
    if (found) {
      add(Verdict::kGood, "the status screen", screen.connector + " of " + found->card + ", " + found->mode);
    } else {
      add(Verdict::kWrong, "the status screen", found.error().message(),
          "correct [screen], or check cable, driver and permissions");
    }
    if (screen.touch.empty()) return;
    const auto touch = TouchPanel::open(screen.touch, layout);
    if (touch) {
      add(Verdict::kGood, "the touch panel", screen.touch);
    } else {
      add(Verdict::kWrong, "the touch panel", touch.error().message(), "correct [screen] touch, or the permissions");
    }
  }

  void check_sensors() {
    for (std::size_t i = 0; i < kTemperatureSiteCount; ++i) {
      const std::string what = "the " + std::string(to_string(static_cast<TemperatureSite>(i))) + " temperature";
      if (!settings_.wiring.thermals.sensors[i].given()) {
        add(Verdict::kWrong, what, "the board file gives no sensor", kAddKeys);
        continue;
      }
      const auto path = find_sensor(settings_.wiring.thermals.sensors[i], settings_.sysfs);
      const auto file = path ? NumberFile::open(*path, NumberFile::Access::kRead)
                             : Expected<NumberFile>(tl::unexpected<Error>(path.error()));
      const auto thousandths = file ? file->read() : std::nullopt;
      const Celsius degrees(static_cast<double>(thousandths.value_or(0)) / 1000);
      if (!file) {
        add(Verdict::kWrong, what, file.error().message(), "correct the board file or check the sensor's driver");
      } else if (!thousandths || degrees < kColdestReading || degrees > kHottestReading) {
        add(Verdict::kWrong, what, *path + ": not a temperature that a printer can have", "check the sensor's plug");
      } else {
        char text[32];
        std::snprintf(text, sizeof text, "%.1f degrees C, ", degrees.value());
        add(Verdict::kGood, what, text + *path);
      }
    }
  }

  void check_fans() {
    for (std::size_t i = 0; i < kFanCount; ++i) {
      const auto& fan = settings_.wiring.thermals.fans[i];
      const std::string what = "the " + std::string(to_string(static_cast<Fan>(i))) + " fan";
      if (!fan.given()) continue;
      const auto place = find_fan(fan, settings_.sysfs);
      if (!place) {
        add(Verdict::kWrong, what, place.error().message(), "correct the board file or check the fan's driver");
      } else if (::access(place->c_str(), W_OK) != 0) {
        add(Verdict::kWrong, what, *place + ": " + std::strerror(errno),
            "let plumbline's user write it, with a udev rule");
      } else {
        add(Verdict::kGood, what, *place);
      }
    }
  }

  void check_stick() {
    if (::access((settings_.sysfs + "/bus/usb/devices").c_str(), R_OK) != 0) {
      add(Verdict::kWrong, "the stick's port", "the kernel has no USB bus",
          "load the driver of the board's USB controller");
    } else if (::access("/run/udev/control", F_OK) != 0) {
      add(Verdict::kWrong, "the stick's port", "udevd does not run, so libusb sees no sticks", "start udevd");
    } else {
      add(Verdict::kGood, "the stick's port", "USB and udevd work");
    }
    for (const char* kind : {"vfat", "exfat"}) {
      std::ifstream file("/proc/filesystems");
      bool known = false;
      for (std::string line; std::getline(file, line);) known = known || line.ends_with(std::string("\t") + kind);
      if (!known) {
        add(Verdict::kPoor, "the stick's file system", std::string("the kernel has not loaded ") + kind,
            std::string("if mounting does not load it: modprobe ") + kind);
      }
    }
    const int mount = connect_to_mount(settings_.mount_socket);
    if (mount < 0) {
      add(Verdict::kWrong, "mounting sticks", std::string("plumbline-mount does not answer: ") + std::strerror(errno),
          "start plumbline-mount.service, and run this as root or as the user plumbline");
    } else {
      ::close(mount);
      add(Verdict::kGood, "mounting sticks", "plumbline-mount answers");
    }
  }

  void check_permissions() {
    rlimit limit{};
    const bool may_run = may(CAP_SYS_NICE) || (::getrlimit(RLIMIT_RTPRIO, &limit) == 0 &&
                                               limit.rlim_cur >= static_cast<rlim_t>(kKeeperPriority));
    if (may_run) {
      add(Verdict::kGood, "real-time priority", "permitted");
    } else {
      add(Verdict::kPoor, "real-time priority", "not permitted: steps and the end of an exposure may be late",
          "run it as its service, or give it CAP_SYS_NICE or an rtprio limit of 50");
    }
    const bool may_lock =
        may(CAP_IPC_LOCK) || (::getrlimit(RLIMIT_MEMLOCK, &limit) == 0 && limit.rlim_cur == RLIM_INFINITY);
    if (may_lock) {
      add(Verdict::kGood, "locked memory", "permitted");
    } else {
      add(Verdict::kPoor, "locked memory", "not permitted: a page fault may delay steps",
          "run it as its service, or give it CAP_IPC_LOCK or an unlimited memlock");
    }
  }

  /// Whether the process has a capability.
  static bool may(int capability) {
    std::ifstream file("/proc/self/status");
    for (std::string line; std::getline(file, line);) {
      if (!line.starts_with("CapEff:")) continue;
      const auto set = std::strtoull(line.c_str() + std::strlen("CapEff:"), nullptr, 16);
      return ((set >> static_cast<unsigned>(capability)) & 1U) != 0;
    }
    return false;
  }

  const LinuxSettings& settings_;
  std::vector<MachineFinding> findings_;
};

}  // namespace

std::vector<MachineFinding> examine_board(const LinuxSettings& settings) { return Examination(settings).run(); }

}  // namespace plumbline::inline hal::inline linux_board
