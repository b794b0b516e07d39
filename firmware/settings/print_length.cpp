#include "firmware/settings/print_length.hpp"

#include <charconv>

#include "slicer/core/numbers/to_number.hpp"
#include "slicer/placement/placement.hpp"

namespace plumbline::firmware::inline settings {
namespace {

std::optional<double> millimetres_in(std::string_view unit) {
  if (unit.empty()) return 1;
  for (const Units known : {Units::kMillimetres, Units::kCentimetres, Units::kInches}) {
    if (unit == to_string(known)) return millimetres_per(known);
  }
  return std::nullopt;
}

}  // namespace

std::optional<FloorChoice> parse_floor(std::string_view text) {
  FloorChoice floor;
  if (text == "auto") return floor;
  floor.kind = FloorChoice::Kind::kKeep;
  if (text == "keep") return floor;
  floor.kind = FloorChoice::Kind::kHeight;
  const auto height = to_number<decltype(floor.height)>(text);
  if (!(height >= -kLargestFloorHeight && height <= kLargestFloorHeight)) return std::nullopt;  // NaN is not
  floor.height = *height;
  return floor;
}

std::optional<double> parse_length(std::string_view text) {
  double number = 0;
  const auto [end, error] = std::from_chars(text.data(), text.data() + text.size(), number);
  if (error != std::errc()) return std::nullopt;
  text.remove_prefix(static_cast<std::size_t>(end - text.data()));
  if (text.starts_with(' ')) text.remove_prefix(1);
  const auto unit_mm = millimetres_in(text);
  const double mm = number * unit_mm.value_or(0);
  if (!(mm >= kSmallestSizeMm && mm <= kLargestSizeMm)) return std::nullopt;  // NaN is not
  return mm;
}

}  // namespace plumbline::firmware::inline settings
