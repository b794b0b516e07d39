#include <CLI/CLI.hpp>

#include "firmware/cli/commands.hpp"
#include "firmware/cli/status_text.hpp"
#include "firmware/io/output_file.hpp"
#include "firmware/state/state_link.hpp"

namespace plumbline {
namespace {

constexpr const char* kFooter =
    "\nExamples:\n"
    "  plumbline status                       what the printer does, what it waits for, and what is wrong\n"
    "  plumbline status --follow              a line for each change, until the daemon ends\n"
    "  plumbline status --json --follow       the same for programs: firmware/state/README.md explains each member\n"
    "  plumbline status --socket state/state  of a simulated printer whose daemon has --state state\n";

/// The daemon answers within a fifth of a second, unless it computes.
constexpr std::chrono::seconds kPatience{10};

}  // namespace

CLI::App* add_status_command(CLI::App& app, StatusOptions& options) {
  auto* command = app.add_subcommand("status", "Show what the running daemon does");
  command->footer(kFooter);
  command->add_option("--socket", options.socket, "The daemon's state socket [/run/plumbline/state]")
      ->type_name("PATH");
  command->add_flag("--follow", options.follow, "Go on: a line for each change");
  command->add_flag("--json", options.json, "For programs: the socket's own lines");
  return command;
}

ExitCode run_status(const StatusOptions& options) {
  auto link = StateLink::open(options.socket, false);
  if (!link) return report_error(link.error());
  const auto first = link->next_of_type("state", kPatience);
  if (!first) return report_error(first.error());
  OutputFile out = OutputFile::standard_output();
  if (const auto told = out.write(options.json ? *first + "\n" : status_page(*first)); !told) {
    return report_error(told.error());
  }
  std::string shown = status_line(*first);
  while (options.follow) {
    const auto line = link->next_line(std::nullopt);
    if (!line) return report_error(line.error());
    if (!*line) break;
    std::string text = options.json ? **line : status_line(**line);
    if (!options.json && text == shown) continue;
    if (const auto told = out.write(text + "\n"); !told) return report_error(told.error());
    shown = std::move(text);
  }
  return ExitCode::kDone;
}

}  // namespace plumbline
