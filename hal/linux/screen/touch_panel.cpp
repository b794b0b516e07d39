#include "hal/linux/screen/touch_panel.hpp"

#include <fcntl.h>
#include <sys/ioctl.h>
#include <unistd.h>

#include <algorithm>
#include <cerrno>
#include <cstring>
#include <utility>

namespace plumbline::inline hal::inline linux_board {
namespace {

/// @returns none: the device has no such axis
std::optional<TouchReader::Range> range_of(int file, unsigned axis, unsigned touch_axis) {
  for (const unsigned code : {axis, touch_axis}) {
    input_absinfo facts{};
    if (::ioctl(file, EVIOCGABS(code), &facts) == 0 && facts.maximum > facts.minimum) {
      return TouchReader::Range{facts.minimum, facts.maximum};
    }
  }
  return std::nullopt;
}

/// A panel's place as a pixel's: 0 to count - 1.
std::uint32_t scaled(std::int32_t value, const TouchReader::Range& range, std::uint32_t count) {
  const std::int64_t clamped = std::clamp(value, range.low, range.high) - std::int64_t{range.low};
  const std::int64_t span = std::int64_t{range.high} - range.low + 1;
  return static_cast<std::uint32_t>(clamped * count / span);
}

}  // namespace

std::optional<ScreenPlace> TouchReader::take(const input_event& event) {
  if (event.type == EV_ABS && (event.code == ABS_X || event.code == ABS_MT_POSITION_X)) x_ = event.value;
  if (event.type == EV_ABS && (event.code == ABS_Y || event.code == ABS_MT_POSITION_Y)) y_ = event.value;
  if (event.type == EV_KEY && event.code == BTN_TOUCH) came_down_ = event.value == 1;
  // The place may be reported before or after the finger: the report is complete at its end.
  if (event.type != EV_SYN || event.code != SYN_REPORT || !std::exchange(came_down_, false)) return std::nullopt;
  const ScreenPlace sent{scaled(x_, x_range_, layout_.sent_columns()), scaled(y_, y_range_, layout_.sent_rows())};
  return place_in_picture(layout_, sent);
}

Expected<TouchPanel> TouchPanel::open(const std::string& device, const ScreenLayout& layout) {
  const int file = ::open(device.c_str(), O_RDONLY | O_NONBLOCK | O_CLOEXEC);
  if (file < 0) {
    return fail(ErrorCode::kCannotOpen,
                "the touch panel %s: %s.\tCorrect [screen] touch, or the permissions (group input)", device.c_str(),
                std::strerror(errno));
  }
  const auto x = range_of(file, ABS_X, ABS_MT_POSITION_X), y = range_of(file, ABS_Y, ABS_MT_POSITION_Y);
  if (!x || !y) {
    ::close(file);
    return fail(ErrorCode::kCannotOpen, "%s is not a touch panel: it reports no positions.\tCorrect [screen] touch",
                device.c_str());
  }
  return TouchPanel(file, TouchReader(layout, *x, *y));
}

TouchPanel::TouchPanel(TouchPanel&& other) noexcept : file_(std::exchange(other.file_, -1)), reader_(other.reader_) {}

TouchPanel::~TouchPanel() {
  if (file_ >= 0) ::close(file_);
}

std::optional<ScreenPlace> TouchPanel::next() {
  input_event event{};
  while (::read(file_, &event, sizeof event) == static_cast<ssize_t>(sizeof event)) {
    if (const auto place = reader_.take(event)) return place;
  }
  return std::nullopt;
}

}  // namespace plumbline::inline hal::inline linux_board
