#include "firmware/cli/options/accepted_values.hpp"

#include <algorithm>
#include <charconv>
#include <climits>
#include <string_view>

#include "firmware/settings/job_options.hpp"
#include "firmware/settings/job_settings.hpp"
#include "firmware/settings/setting_words.hpp"

namespace plumbline::firmware {
namespace {

constexpr std::size_t kLongestShown = 40;

std::string not_accepted(const std::string& text, const std::string& wanted) {
  return "'" + printable(text, kLongestShown) + "' is not " + wanted;
}

/// "; write it in mm, without a unit", for the mistakes that people make with numbers, or "".
std::string correction(const std::string& text, std::string_view unit) {
  std::string with_point = text;
  std::replace(with_point.begin(), with_point.end(), ',', '.');
  double value = 0;
  const char* const end = text.data() + text.size();
  const auto read = std::from_chars(text.data(), end, value);
  if (read.ec != std::errc() || read.ptr == end) return {};
  if (*read.ptr == ',' && CLI::detail::lexical_cast(with_point, value))
    return "; write it with a decimal point: " + printable(with_point, kLongestShown);
  return unit.empty() ? "; write the number alone" : "; write it in " + std::string(unit) + ", without a unit";
}

}  // namespace

CLI::Validator number_from(double low, double high, const char* unit) {
  return CLI::Validator(
      [low, high, unit](std::string& text) -> std::string {
        double given = 0;
        if (CLI::detail::lexical_cast(text, given) && given >= low && given <= high) return {};
        const std::string end = *unit ? std::string(" ") + unit : "";
        return not_accepted(text, "a number from " + number(low) + " to " + number(high) + end) +
               correction(text, unit);
      },
      "");
}

CLI::Validator layer_height() {
  return CLI::Validator(
      [number = number_from(kFinestMm, kCoarsestMm, "mm")](std::string& text) -> std::string {
        if (text != kAdaptiveWord) return number(text);
        text = std::to_string(kAdaptiveHeight);
        return {};
      },
      "");
}

CLI::Validator whole_number_from(unsigned long long low, unsigned long long high) {
  return CLI::Validator(
      [low, high](std::string& text) -> std::string {
        unsigned long long given = 0;
        const char* const end = text.data() + text.size();
        const auto read = std::from_chars(text.data(), end, given);
        if (read.ec == std::errc() && read.ptr == end && given >= low && given <= high) return {};
        const bool bounded = high < UINT_MAX;
        return not_accepted(text, std::string("a whole number ") + (bounded ? "from " : "of at least ") +
                                      std::to_string(low) + (bounded ? " to " + std::to_string(high) : ""));
      },
      "");
}

CLI::Validator one_of(const std::vector<std::string>& words) {
  return CLI::Validator(
      [words](std::string& text) -> std::string {
        if (std::find(words.begin(), words.end(), text) != words.end()) return {};
        const std::vector<std::string_view> known(words.begin(), words.end());
        const auto near = nearest_within(text, known);
        return not_accepted(text, "one of " + joined(known)) +
               (near && text.size() > 2 ? "; did you mean " + std::string(*near) + "?" : "");
      },
      "");
}

}  // namespace plumbline::firmware
