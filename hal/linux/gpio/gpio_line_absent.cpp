/// Replaces gpio_line.cpp in a build without libgpiod: refuses every line and says why.

#include "hal/linux/gpio/gpio_line.hpp"

namespace plumbline::inline hal::inline linux_board {
namespace {

tl::unexpected<Error> absent(const std::string& use) {
  return fail(
      ErrorCode::kUnsupported,
      "the line of %s: this plumbline was built without libdrm, libgpiod or libusb, so it can't drive a printer",
      use.c_str());
}

}  // namespace

void ReleaseLine::operator()(gpiod_line* /*line*/) const {}

Expected<LinePlace> find_line(const LineSettings& /*settings*/, const std::string& use) { return absent(use); }
Expected<std::string> holder_of(const LinePlace& /*place*/) { return absent("the board"); }

std::vector<GpioChip> list_gpio_chips() { return {}; }

Expected<OutputLine> OutputLine::open(const LinePlace& /*place*/, const LineSettings& /*settings*/,
                                      const std::string& use, bool /*on*/) {
  return absent(use);
}
bool OutputLine::set(bool /*on*/) noexcept { return false; }

Expected<InputLine> InputLine::open(const LinePlace& /*place*/, const LineSettings& /*settings*/,
                                    const std::string& use) {
  return absent(use);
}
std::optional<bool> InputLine::on() const noexcept { return std::nullopt; }
std::optional<InputLine::Edge> InputLine::next_edge() noexcept { return std::nullopt; }

}  // namespace plumbline::inline hal::inline linux_board
