/// The program `plumbline-keeper`: holds the lamp's line for the firmware, which starts it.
///
///   plumbline-keeper --line LINE [--cover LINE] [--watchdog DEVICE --watchdog-s SECONDS] --longest-ns N --per-minute-ns N
///                    [--lit-ns N] --firmware PID
///
/// Descriptors 3 and 4 are the sockets to the firmware (keeper_protocol.hpp). LINE is gpio:CHIP:OFFSET:high|low:BIAS, where high or
/// low is the voltage that lights the lamp or means an open cover; or for tests file:PATH, to which the lamp's changes are written, or
/// a FIFO from which the cover's are read. DEVICE may be file:PATH in the same way.

#include <unistd.h>

#include <cstdio>
#include <cstdlib>
#include <cstring>
#include <memory>
#include <optional>
#include <string_view>

#include "hal/linux/events/real_time.hpp"
#include "hal/linux/keeper/keeper.hpp"
#include "hal/linux/keeper/keeper_lines.hpp"
#include "hal/linux/keeper/keeper_protocol.hpp"
#include "hal/process/process_memory.hpp"

namespace plumbline::inline hal::inline linux_board {
namespace {

struct CommandLine {
  std::string_view line;
  std::string_view cover;
  std::string_view watchdog;
  long long watchdog_s = 0;
  long long longest_ns = 0;
  long long per_minute_ns = 0;
  long long lit_ns = 0;
  long long firmware = 0;

  bool complete() const { return !line.empty() && firmware > 0 && longest_ns > 0 && per_minute_ns > 0; }
};

CommandLine parse(int argc, char** argv) {
  CommandLine options;
  for (int i = 1; i + 1 < argc; i += 2) {
    const std::string_view name = argv[i];
    const char* const value = argv[i + 1];
    const long long number = std::strtoll(value, nullptr, 10);
    if (name == "--line") options.line = value;
    if (name == "--cover") options.cover = value;
    if (name == "--watchdog") options.watchdog = value;
    if (name == "--watchdog-s") options.watchdog_s = number;
    if (name == "--longest-ns") options.longest_ns = number;
    if (name == "--per-minute-ns") options.per_minute_ns = number;
    if (name == "--lit-ns") options.lit_ns = number;
    if (name == "--firmware") options.firmware = number;
  }
  return options;
}

/// A keeper whose firmware has just been killed needs a moment to turn the line off and release it.
Expected<std::unique_ptr<LampLine>> take_lamp_line(std::string_view text) {
  constexpr int kTries = 100;
  constexpr useconds_t kBetween = 10'000;  // us: 1 s in all, as long as a keeper tries to turn a line off
  auto line = open_lamp_line(text);
  for (int tries = 1; tries < kTries && !line && line.error().code() == ErrorCode::kCannotOpen; ++tries) {
    ::usleep(kBetween);
    line = open_lamp_line(text);
  }
  return line;
}

int refuse(const Error& error) {
  std::fprintf(stderr, "plumbline-keeper: %s\n", error.message());
  return 1;
}

int run(const CommandLine& options) {
  // Both help to meet the deadline. The keeper also works if they are not permitted.
  static_cast<void>(lock_memory(Untouched::kLoad));
  static_cast<void>(set_real_time_priority(kKeeperPriority));

  const auto lamp = take_lamp_line(options.line);
  if (!lamp) return refuse(lamp.error());
  const auto cover = open_cover_line(options.cover);
  if (!cover) return refuse(cover.error());
  std::optional<Watchdog> watchdog;
  if (!options.watchdog.empty()) {
    auto opened = Watchdog::open(options.watchdog, std::chrono::seconds(options.watchdog_s));
    if (!opened) return refuse(opened.error());
    watchdog.emplace(std::move(*opened));
  }
  return keep_lamp(
      {.line = **lamp,
       .cover = cover->get(),
       .watchdog = watchdog ? &*watchdog : nullptr,
       .socket = kKeeperSocket,
       .watch_socket = kKeeperWatchSocket,
       .firmware = static_cast<pid_t>(options.firmware),
       .limits = {std::chrono::nanoseconds(options.longest_ns), std::chrono::nanoseconds(options.per_minute_ns)},
       .lit_before = std::chrono::nanoseconds(options.lit_ns)});
}

}  // namespace
}  // namespace plumbline::inline hal::inline linux_board

int main(int argc, char** argv) {
  const auto options = plumbline::parse(argc, argv);
  if (!options.complete()) {
    std::fputs("plumbline-keeper: holds the lamp's line for plumbline and plumblined, which start it\n", stderr);
    return 2;
  }
  return plumbline::run(options);
}
