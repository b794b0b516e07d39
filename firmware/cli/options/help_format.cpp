#include "firmware/cli/options/help_format.hpp"

namespace plumbline::firmware {

std::string HelpFormat::make_option_opts(const CLI::Option* option) const {
  std::string text;
  if (option->get_type_size() != 0 && !option->get_type_name().empty()) text += " " + option->get_type_name();
  if (option->get_required() && !option->get_positional()) text += " (required)";
  return text;
}

/// CLI11 indents what follows a line feed.
std::string HelpFormat::make_option_desc(const CLI::Option* option) const {
  constexpr std::size_t kWidth = 120 - kOptionColumns;
  std::string rest = option->get_description();
  std::string lines;
  while (rest.size() > kWidth) {
    const std::size_t space = rest.rfind(' ', kWidth);
    if (space == std::string::npos) break;
    lines += rest.substr(0, space) + "\n";
    rest.erase(0, space + 1);
  }
  return lines + rest;
}

std::string HelpFormat::make_option_usage(const CLI::Option* positional) const {
  const std::string name = positional->get_type_name() + (positional->get_expected_max() > 1 ? "..." : "");
  return positional->get_required() ? name : "[" + name + "]";
}

}  // namespace plumbline::firmware
