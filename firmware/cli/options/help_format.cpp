#include "firmware/cli/options/help_format.hpp"

#include <memory>
#include <sstream>
#include <utility>

namespace plumbline::firmware {
namespace {

/// The first sentence, without the point at its end.
std::string first_sentence(const std::string& text) { return text.substr(0, text.find(". ")); }

/// The footer's examples: it begins with them, and an empty line ends them.
std::string examples_of(const CLI::App& app) {
  const std::string footer = app.get_footer();
  return footer.substr(0, footer.find("\n\n", 1));
}

}  // namespace

std::string HelpFormat::make_help(const CLI::App* app, std::string name, CLI::AppFormatMode mode) const {
  if (basic_.empty() || mode != CLI::AppFormatMode::Normal) return Formatter::make_help(app, std::move(name), mode);
  std::string text = make_description(app) + make_usage(app, name) + make_positionals(app) + "\nOptions:\n";
  std::stringstream lines;
  for (const std::string& basic : basic_) {
    const CLI::Option* const option = app->get_option(basic);
    CLI::detail::format_help(lines, make_option_name(option, false) + make_option_opts(option),
                             first_sentence(option->get_description()), get_column_width());
  }
  return text + lines.str() + examples_of(*app) + "\n\n'" + name +
         " --help-all' lists all options, and explains output and exit status.\n";
}

void show_basic(CLI::App& command, std::vector<std::string> basic) {
  command.set_help_flag("-h,--help", "Print the most used options, and exit");
  command.set_help_all_flag("--help-all", "Print all options, and exit");
  basic.insert(basic.end(), {"--help", "--help-all"});
  command.formatter(std::make_shared<HelpFormat>(std::move(basic)));
}

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
