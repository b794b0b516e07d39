#include "hal/linux/keeper/keeper_lines.hpp"

#include <cerrno>
#include <cstring>
#include <optional>
#include <string>

#include "hal/linux/keeper/file_cover_line.hpp"
#include "hal/linux/keeper/file_lamp_line.hpp"
#include "hal/linux/keeper/gpio_keeper_lines.hpp"

namespace plumbline::inline hal::inline linux_board {
namespace {

constexpr std::string_view kFile = "file:";

/// Opens a file that plays a line.
template <class File>
Expected<std::unique_ptr<File>> open_file(std::string_view text, const char* use) {
  auto file = std::make_unique<File>(std::string(text.substr(kFile.size())));
  if (!file->ok()) return fail(ErrorCode::kCannotOpen, "the line of %s: %s", use, std::strerror(errno));
  return file;
}

Expected<LineOption> parse(std::string_view text, const char* use) {
  const auto option = parse_line_option(text);
  if (option) return *option;
  return fail(ErrorCode::kBadSetting,
              "the line of %s: found '%.*s', allowed is gpio:CHIP:OFFSET:high|low:BIAS, or file:PATH", use,
              static_cast<int>(text.size()), text.data());
}

}  // namespace

Expected<std::unique_ptr<LampLine>> open_lamp_line(std::string_view text) {
  if (text.starts_with(kFile)) return open_file<FileLampLine>(text, "the lamp");
  const auto option = parse(text, "the lamp");
  PLUMBLINE_TRY(option);
  auto line = OutputLine::open(option->place, option->settings, "the lamp", false);
  PLUMBLINE_TRY(line);
  return std::make_unique<GpioLampLine>(std::move(*line));
}

Expected<std::unique_ptr<CoverLine>> open_cover_line(std::string_view text) {
  if (text.empty()) return nullptr;
  if (text.starts_with(kFile)) return open_file<FileCoverLine>(text, "the cover");
  const auto option = parse(text, "the cover");
  PLUMBLINE_TRY(option);
  auto line = InputLine::open(option->place, option->settings, "the cover");
  PLUMBLINE_TRY(line);
  return std::make_unique<GpioCoverLine>(std::move(*line));
}

}  // namespace plumbline::inline hal::inline linux_board
