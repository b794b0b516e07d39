#pragma once
/// How `--help` looks.

#include <CLI/CLI.hpp>

namespace plumbline::firmware {

/// CLI11's layout with lines of at most 120 characters, and without the lists of options that need or exclude each other:
/// the message about a wrong combination names them.
class HelpFormat final : public CLI::Formatter {
 public:
  static constexpr std::size_t kOptionColumns = 30;  ///< characters for the option, before its description

  HelpFormat() { column_width(kOptionColumns); }
  std::string make_option_opts(const CLI::Option* option) const override;
  std::string make_option_desc(const CLI::Option* option) const override;
  std::string make_option_usage(const CLI::Option* positional) const override;
};

}  // namespace plumbline::firmware
