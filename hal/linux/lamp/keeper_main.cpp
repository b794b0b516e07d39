/// The program `plumbline-keeper`: holds the lamp's line for the firmware, which starts it.
///
///   plumbline-keeper --line LINE [--cover LINE] --firmware PID       descriptor 3 is the socket to the firmware
///
/// LINE is gpio:CHIP:OFFSET:high|low:BIAS, where high or low is the voltage that lights the lamp or means an open cover; or for
/// tests file:PATH, to which the lamp's changes are written, or a FIFO from which the cover's are read.

#include <cerrno>
#include <cstdio>
#include <cstdlib>
#include <cstring>
#include <memory>
#include <string>
#include <string_view>

#include "hal/linux/events/real_time.hpp"
#include "hal/linux/lamp/file_cover_line.hpp"
#include "hal/linux/lamp/file_lamp_line.hpp"
#include "hal/linux/lamp/gpio_keeper_lines.hpp"
#include "hal/linux/lamp/keeper.hpp"

namespace plumbline {
namespace {

constexpr std::string_view kFile = "file:";

template <class Line>
using Opened = Expected<std::unique_ptr<Line>>;

Opened<LampLine> open_lamp(std::string_view text) {
  if (text.starts_with(kFile)) {
    auto file = std::make_unique<FileLampLine>(std::string(text.substr(kFile.size())));
    if (!file->ok()) return fail(ErrorCode::kCannotOpen, "the lamp's line: %s", std::strerror(errno));
    return file;
  }
  const auto option = parse_line_option(text);
  if (!option) return fail(ErrorCode::kBadSetting, "the lamp's line: gpio:CHIP:OFFSET:high|low:BIAS, or file:PATH");
  auto line = OutputLine::open(option->place, option->settings, "the lamp", false);
  if (!line) return tl::unexpected<Error>(line.error());
  return std::make_unique<GpioLampLine>(std::move(*line));
}

Opened<CoverLine> open_cover(std::string_view text) {
  if (text.empty()) return nullptr;
  if (text.starts_with(kFile)) {
    auto file = std::make_unique<FileCoverLine>(std::string(text.substr(kFile.size())));
    if (!file->ok()) return fail(ErrorCode::kCannotOpen, "the cover's line: %s", std::strerror(errno));
    return file;
  }
  const auto option = parse_line_option(text);
  if (!option) return fail(ErrorCode::kBadSetting, "the cover's line: gpio:CHIP:OFFSET:high|low:BIAS, or file:PATH");
  auto line = InputLine::open(option->place, option->settings, "the cover");
  if (!line) return tl::unexpected<Error>(line.error());
  return std::make_unique<GpioCoverLine>(std::move(*line));
}

int run(std::string_view lamp_text, std::string_view cover_text, int firmware) {
  constexpr int kSocket = 3;
  // Both help to meet the deadline. The keeper also works if they are not permitted.
  static_cast<void>(lock_memory());
  static_cast<void>(set_real_time_priority(kKeeperPriority));

  const auto lamp = open_lamp(lamp_text);
  const auto cover = open_cover(cover_text);
  if (!lamp || !cover) {
    std::fprintf(stderr, "plumbline-keeper: %s\n", (lamp ? cover.error() : lamp.error()).message());
    return 1;
  }
  return keep_lamp(**lamp, cover->get(), kSocket, firmware);
}

}  // namespace
}  // namespace plumbline

int main(int argc, char** argv) {
  std::string_view lamp;
  std::string_view cover;
  int firmware = 0;
  for (int i = 1; i + 1 < argc; i += 2) {
    if (std::strcmp(argv[i], "--line") == 0) lamp = argv[i + 1];
    if (std::strcmp(argv[i], "--cover") == 0) cover = argv[i + 1];
    if (std::strcmp(argv[i], "--firmware") == 0) firmware = static_cast<int>(std::strtol(argv[i + 1], nullptr, 10));
  }
  if (lamp.empty() || firmware <= 0) {
    std::fputs("plumbline-keeper: started by the firmware: --line LINE [--cover LINE] --firmware PID\n", stderr);
    return 2;
  }
  return plumbline::run(lamp, cover, firmware);
}
