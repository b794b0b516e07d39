#include "hal/linux/examination.hpp"

#include <linux/capability.h>
#include <sys/resource.h>
#include <unistd.h>

#include <cerrno>
#include <cstdio>
#include <cstring>
#include <fstream>

#include "hal/linux/events/real_time.hpp"
#include "hal/linux/gpio/gpio_line.hpp"
#include "hal/linux/linux_machine.hpp"

namespace plumbline {
namespace {

using Verdict = BoardFinding::Verdict;

class Examination {
 public:
  explicit Examination(const LinuxSettings& settings) : settings_(settings) {}

  std::vector<BoardFinding> run() {
    look_at_lines();
    look_at_keeper();
    look_at_panel();
    look_at_sensors();
    look_at_fans();
    look_at_stick();
    look_at_rights();
    return std::move(findings_);
  }

 private:
  void add(Verdict verdict, std::string what, std::string found, std::string advice = "") {
    findings_.push_back({verdict, std::move(what), std::move(found), std::move(advice)});
  }

  void look_at_lines() {
    LineRegistry registry;
    for (const auto& line : lines_of(settings_)) {
      const std::string what = line.use + "'s line";
      if (!line.settings->given()) {
        look_at_missing(line, what);
        continue;
      }
      const auto place = find_line(*line.settings, line.use);
      if (!place) {
        add(Verdict::kWrong, what, place.error().message(), "correct the board file, or see to the right");
        continue;
      }
      const std::string found = place->chip + " line " + std::to_string(place->offset);
      const auto claimed = registry.claim(*place, line.use);
      const auto holder = holder_of(*place);
      if (!claimed) {
        add(Verdict::kWrong, what, claimed.error().message(), "give each its own line");
      } else if (!holder) {
        add(Verdict::kWrong, what, holder.error().message(), "see to the right, or to the chip's driver");
      } else if (holder->empty() || *holder == "plumbline") {
        add(Verdict::kGood, what, found + (holder->empty() ? "" : ", held by a plumbline that runs"));
      } else {
        add(Verdict::kWrong, what, found + ", held by " + *holder, "end that program, or use another line");
      }
    }
  }

  void look_at_missing(const BoardLines::Line& line, const std::string& what) {
    const bool needed = line.settings == &settings_.lamp_line || line.settings == &settings_.step ||
                        line.settings == &settings_.direction || line.settings == &settings_.end_stop;
    if (needed) {
      add(Verdict::kWrong, what, "the board file gives none", "add it: board/README.md has the keys");
    } else if (line.settings == &settings_.cover) {
      add(Verdict::kPoor, what, "the board file gives none: nothing turns the lamp off when the cover is opened",
          "fit a switch, and add [cover_line]");
    }
  }

  void look_at_keeper() {
    if (::access(settings_.keeper.c_str(), X_OK) == 0) {
      add(Verdict::kGood, "the lamp's keeper", settings_.keeper);
    } else {
      add(Verdict::kWrong, "the lamp's keeper", settings_.keeper + ": " + std::strerror(errno),
          "install plumbline-keeper beside plumbline; without it no lamp is lit");
    }
  }

  void look_at_panel() {
    if (const auto layout = settings_.panel.check(); !layout) {
      add(Verdict::kWrong, "the panel", layout.error().message(), "correct [panel] of the board file");
      return;
    }
    const auto found = KmsPanel::look(settings_.display, settings_.panel.mode_width(), settings_.panel.mode_height());
    if (found) {
      add(Verdict::kGood, "the panel",
          settings_.display.connector + " of " + found->card + ", " + found->mode +
              (found->atomic ? ", atomic" : ", without atomic requests"));
    } else {
      add(Verdict::kWrong, "the panel", found.error().message(), "correct [display], or see to cable, driver or right");
    }
  }

  void look_at_sensors() {
    constexpr std::int64_t kColdest = -30'000;
    constexpr std::int64_t kHottest = 150'000;
    for (std::size_t i = 0; i < kTemperatureSiteCount; ++i) {
      const std::string what = "the " + std::string(to_string(static_cast<TemperatureSite>(i))) + "'s temperature";
      if (!settings_.thermals.sensors[i].given()) {
        add(Verdict::kWrong, what, "the board file gives no sensor", "add it: board/README.md has the keys");
        continue;
      }
      const auto path = find_sensor(settings_.thermals.sensors[i], settings_.sysfs);
      const auto file = path ? NumberFile::open(*path, NumberFile::Access::kRead)
                             : Expected<NumberFile>(tl::unexpected<Error>(path.error()));
      const auto read = file ? file->read() : std::nullopt;
      if (!file) {
        add(Verdict::kWrong, what, file.error().message(), "correct the board file, or see to the sensor's driver");
      } else if (!read || *read < kColdest || *read > kHottest) {
        add(Verdict::kWrong, what, *path + ": no temperature that a printer can have", "check the sensor's plug");
      } else {
        char text[32];
        std::snprintf(text, sizeof text, "%.1f degrees, ", static_cast<double>(*read) / 1000);
        add(Verdict::kGood, what, text + *path);
      }
    }
  }

  void look_at_fans() {
    for (std::size_t i = 0; i < kFanCount; ++i) {
      const auto& fan = settings_.thermals.fans[i];
      const std::string what = "the " + std::string(to_string(static_cast<Fan>(i))) + " fan";
      if (!fan.given()) continue;
      const auto place = find_fan(fan, settings_.sysfs);
      if (!place) {
        add(Verdict::kWrong, what, place.error().message(), "correct the board file, or see to the fan's driver");
      } else if (::access(place->c_str(), W_OK) != 0) {
        add(Verdict::kWrong, what, *place + ": " + std::strerror(errno), "let plumbline's user write it: a udev rule");
      } else {
        add(Verdict::kGood, what, *place);
      }
    }
  }

  void look_at_stick() {
    if (::access((settings_.sysfs + "/bus/usb/devices").c_str(), R_OK) != 0) {
      add(Verdict::kWrong, "the stick's port", "the kernel has no USB",
          "load the driver of the board's USB controller");
    } else if (::access("/run/udev/control", F_OK) != 0) {
      add(Verdict::kWrong, "the stick's port", "udevd does not run, and libusb hears of sticks from it", "start udevd");
    } else {
      add(Verdict::kGood, "the stick's port", "USB and udevd are there");
    }
    for (const char* kind : {"vfat", "exfat"}) {
      std::ifstream file("/proc/filesystems");
      bool known = false;
      for (std::string line; std::getline(file, line);) known = known || line.ends_with(std::string("\t") + kind);
      if (!known) {
        add(Verdict::kPoor, "the stick's file system", std::string("the kernel has not loaded ") + kind,
            std::string("modprobe ") + kind + ", where mounting does not load it by itself");
      }
    }
    if (!may(CAP_SYS_ADMIN)) {
      add(Verdict::kWrong, "the right to mount", "not given (CAP_SYS_ADMIN)", "run it as its service, or as root");
    } else {
      add(Verdict::kGood, "the right to mount", "given; sticks are mounted at " + settings_.stick.mount_point);
    }
  }

  void look_at_rights() {
    rlimit limit{};
    const bool may_run = may(CAP_SYS_NICE) || (::getrlimit(RLIMIT_RTPRIO, &limit) == 0 &&
                                               limit.rlim_cur >= static_cast<rlim_t>(kKeeperPriority));
    if (may_run) {
      add(Verdict::kGood, "real-time priority", "permitted");
    } else {
      add(Verdict::kPoor, "real-time priority", "not permitted: steps and the lamp's end may come late",
          "run it as its service, or give it CAP_SYS_NICE or an rtprio limit of 50");
    }
    const bool may_lock =
        may(CAP_IPC_LOCK) || (::getrlimit(RLIMIT_MEMLOCK, &limit) == 0 && limit.rlim_cur == RLIM_INFINITY);
    if (may_lock) {
      add(Verdict::kGood, "locked memory", "permitted");
    } else {
      add(Verdict::kPoor, "locked memory", "not permitted: steps may wait for a page",
          "run it as its service, or give it CAP_IPC_LOCK or an unlimited memlock");
    }
  }

  /// The effective set, as the kernel has it.
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
  std::vector<BoardFinding> findings_;
};

}  // namespace

std::vector<BoardFinding> examine_board(const LinuxSettings& settings) { return Examination(settings).run(); }

}  // namespace plumbline
