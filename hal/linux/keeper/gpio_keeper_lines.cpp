#include "hal/linux/keeper/gpio_keeper_lines.hpp"

#include <algorithm>
#include <array>

#include "slicer/core/numbers/to_number.hpp"

namespace plumbline::inline hal::inline linux_board {
namespace {

constexpr std::string_view kGpio = "gpio";

}  // namespace

std::string line_option(const LinePlace& place, const LineSettings& settings) {
  std::string text(kGpio);
  for (const auto& part : {place.chip, std::to_string(place.offset), std::string(settings.active_low ? "low" : "high"),
                           std::string(kLineBiasWords[static_cast<std::size_t>(settings.bias)])}) {
    text += ':';
    text += part;
  }
  return text;
}

std::optional<LineOption> parse_line_option(std::string_view text) {
  std::array<std::string_view, 5> parts;
  for (std::size_t i = 0; i < parts.size(); ++i) {
    const auto end = text.find(':');
    if ((end == std::string_view::npos) != (i + 1 == parts.size())) return std::nullopt;
    parts[i] = text.substr(0, end);
    text.remove_prefix(std::min(text.size(), parts[i].size() + 1));
  }
  LineOption option;
  option.place.chip = parts[1];
  const auto offset = to_number<std::uint32_t>(parts[2]);
  const auto* const bias = std::find(kLineBiasWords.begin(), kLineBiasWords.end(), parts[4]);
  if (parts[0] != kGpio || parts[1].empty() || !offset || (parts[3] != "low" && parts[3] != "high") ||
      bias == kLineBiasWords.end()) {
    return std::nullopt;
  }
  option.place.offset = *offset;
  option.settings.active_low = parts[3] == "low";
  option.settings.bias = static_cast<LineBias>(bias - kLineBiasWords.begin());
  return option;
}

}  // namespace plumbline::inline hal::inline linux_board
