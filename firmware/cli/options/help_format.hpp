#pragma once
/// How `--help` looks.

#include <CLI/CLI.hpp>
#include <string>
#include <vector>

namespace plumbline::firmware {

/// CLI11's layout with lines of at most 120 characters, and without the lists of options that need or exclude each other:
/// the message about a wrong combination names them.
class HelpFormat final : public CLI::Formatter {
 public:
  static constexpr std::size_t kOptionColumns = 30;  ///< characters for the option, before its description

  /// @param basic  options that `--help` shows, in this order; the others are for `--help-all`. Empty: it shows all
  explicit HelpFormat(std::vector<std::string> basic = {}) : basic_(std::move(basic)) { column_width(kOptionColumns); }
  std::string make_help(const CLI::App* app, std::string name, CLI::AppFormatMode mode) const override;
  std::string make_option_opts(const CLI::Option* option) const override;
  std::string make_option_desc(const CLI::Option* option) const override;
  std::string make_option_usage(const CLI::Option* positional) const override;

 private:
  std::vector<std::string> basic_;
};

/// Gives a command `--help-all`, and lets its `--help` show these options alone, each by the first sentence of its description,
/// and the examples. Call it when the command has all its options.
void show_basic(CLI::App& command, std::vector<std::string> basic);

}  // namespace plumbline::firmware
