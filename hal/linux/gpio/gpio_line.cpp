#include "hal/linux/gpio/gpio_line.hpp"

#include <fcntl.h>
#include <gpiod.h>
#include <unistd.h>

#include <cerrno>
#include <cstring>

namespace plumbline::inline hal::inline linux_board {
namespace {

constexpr const char* kConsumer = "plumbline";

std::string to_text(const LinePlace& place) { return place.chip + " line " + std::to_string(place.offset); }

/// Opens a line's chip. @returns null with errno set
HeldLine open_line(const LinePlace& place) {
  gpiod_chip* const chip = ::gpiod_chip_open_by_name(place.chip.c_str());
  if (chip == nullptr) return nullptr;
  gpiod_line* const line = ::gpiod_chip_get_line(chip, place.offset);
  if (line == nullptr) {
    const int reason = errno;
    ::gpiod_chip_close(chip);
    errno = reason;
  }
  return HeldLine(line);
}

gpiod_line_request_config config_of(const LineSettings& settings, int type) {
  gpiod_line_request_config config{};
  config.consumer = kConsumer;
  config.request_type = type;
  if (settings.active_low) config.flags |= GPIOD_LINE_REQUEST_FLAG_ACTIVE_LOW;
  switch (settings.bias) {
    case LineBias::kAsIs: break;
    case LineBias::kDisabled: config.flags |= GPIOD_LINE_REQUEST_FLAG_BIAS_DISABLE; break;
    case LineBias::kPullUp: config.flags |= GPIOD_LINE_REQUEST_FLAG_BIAS_PULL_UP; break;
    case LineBias::kPullDown: config.flags |= GPIOD_LINE_REQUEST_FLAG_BIAS_PULL_DOWN; break;
  }
  return config;
}

tl::unexpected<Error> cannot_use(const LinePlace& place, const std::string& use, int reason) {
  const char* next = "";
  if (reason == EBUSY) next = ": another program or driver holds it, see gpioinfo";
  if (reason == EACCES || reason == EPERM) next = ": run as a member of the group gpio";
  return fail(ErrorCode::kCannotOpen, "the line of %s, %s: %s%s", use.c_str(), to_text(place).c_str(),
              std::strerror(reason), next);
}

}  // namespace

void ReleaseLine::operator()(gpiod_line* line) const {
  ::gpiod_chip_close(::gpiod_line_get_chip(line));  // releases its lines
}

std::vector<GpioChip> list_gpio_chips() {
  std::vector<GpioChip> chips;
  const auto text = [](const char* name) { return std::string(name == nullptr ? "" : name); };
  // gpiod_chip_iter gives up at the first chip that can't be opened.
  for (unsigned number = 0; ::access(("/dev/gpiochip" + std::to_string(number)).c_str(), F_OK) == 0; ++number) {
    gpiod_chip* const chip = ::gpiod_chip_open_by_number(number);
    if (chip == nullptr) continue;
    GpioChip found{text(::gpiod_chip_name(chip)), text(::gpiod_chip_label(chip)), {}};
    for (unsigned offset = 0; offset < ::gpiod_chip_num_lines(chip); ++offset) {
      gpiod_line* const line = ::gpiod_chip_get_line(chip, offset);
      if (line == nullptr) continue;
      const char* const holder = ::gpiod_line_consumer(line);
      found.lines.push_back({offset, text(::gpiod_line_name(line)),
                             holder != nullptr            ? holder
                             : ::gpiod_line_is_used(line) ? "the kernel"
                                                          : ""});
    }
    ::gpiod_chip_close(chip);
    chips.push_back(std::move(found));
  }
  return chips;
}

Expected<LinePlace> find_line(const LineSettings& settings, const std::string& use) {
  if (!settings.name.empty()) {
    errno = 0;
    const HeldLine line(::gpiod_line_find(settings.name.c_str()));
    if (!line) {
      if (errno == EACCES || errno == EPERM) {
        return fail(ErrorCode::kCannotOpen,
                    "the line of %s: no permission for the GPIO chips: run as a user of the "
                    "group gpio",
                    use.c_str());
      }
      return fail(ErrorCode::kBadSetting, "the line of %s: no chip of this board has a line named %s, see gpioinfo",
                  use.c_str(), settings.name.c_str());
    }
    return LinePlace{::gpiod_chip_name(::gpiod_line_get_chip(line.get())), ::gpiod_line_offset(line.get())};
  }
  gpiod_chip* const chip = ::gpiod_chip_open_lookup(settings.chip.c_str());
  if (chip == nullptr) {
    const int reason = errno;
    return fail(reason == ENOENT ? ErrorCode::kBadSetting : ErrorCode::kCannotOpen,
                "the line of %s: chip %s: %s, see gpiodetect", use.c_str(), settings.chip.c_str(),
                std::strerror(reason));
  }
  LinePlace place{::gpiod_chip_name(chip), settings.offset};
  const unsigned lines = ::gpiod_chip_num_lines(chip);
  ::gpiod_chip_close(chip);
  if (place.offset >= lines) {
    return fail(ErrorCode::kBadSetting, "the line of %s: chip %s has lines 0 to %u, and not %u", use.c_str(),
                place.chip.c_str(), lines - 1, place.offset);
  }
  return place;
}

Expected<std::string> holder_of(const LinePlace& place) {
  const HeldLine line = open_line(place);
  if (!line) return cannot_use(place, "the board", errno);
  if (!::gpiod_line_is_used(line.get())) return std::string();
  const char* const consumer = ::gpiod_line_consumer(line.get());
  return std::string(consumer != nullptr ? consumer : "the kernel");
}

Expected<OutputLine> OutputLine::open(const LinePlace& place, const LineSettings& settings, const std::string& use,
                                      bool on) {
  HeldLine line = open_line(place);
  const auto config = config_of(settings, GPIOD_LINE_REQUEST_DIRECTION_OUTPUT);
  if (!line || ::gpiod_line_request(line.get(), &config, on ? 1 : 0) != 0) return cannot_use(place, use, errno);
  return OutputLine(std::move(line));
}

bool OutputLine::set(bool on) noexcept { return ::gpiod_line_set_value(line_.get(), on ? 1 : 0) == 0; }

Expected<InputLine> InputLine::open(const LinePlace& place, const LineSettings& settings, const std::string& use) {
  HeldLine line = open_line(place);
  const auto config = config_of(settings, GPIOD_LINE_REQUEST_EVENT_BOTH_EDGES);
  if (!line || ::gpiod_line_request(line.get(), &config, 0) != 0) return cannot_use(place, use, errno);
  const int events = ::gpiod_line_event_get_fd(line.get());
  const int flags = events < 0 ? -1 : ::fcntl(events, F_GETFL);
  if (flags < 0 || ::fcntl(events, F_SETFL, flags | O_NONBLOCK) != 0) return cannot_use(place, use, errno);
  return InputLine(std::move(line), events);
}

std::optional<bool> InputLine::on() const noexcept {
  const int value = ::gpiod_line_get_value(line_.get());
  if (value < 0) return std::nullopt;
  return value != 0;
}

std::optional<InputLine::Edge> InputLine::next_edge() noexcept {
  gpiod_line_event event{};
  if (::gpiod_line_event_read_fd(events_, &event) != 0) return std::nullopt;
  return Edge{event.event_type == GPIOD_LINE_EVENT_RISING_EDGE,
              std::chrono::seconds(event.ts.tv_sec) + std::chrono::nanoseconds(event.ts.tv_nsec)};
}

}  // namespace plumbline::inline hal::inline linux_board
