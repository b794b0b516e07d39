#include <CLI/CLI.hpp>

#include "firmware/cli/commands.hpp"
#include "firmware/daemon/button_socket.hpp"

namespace plumbline {
namespace {

constexpr const char* kFooter =
    "\nExamples:\n"
    "  plumbline press start                  print the job on the stick, resume a print, or say that the plate is "
    "empty\n"
    "  plumbline press cancel --state state   of a daemon with another state folder\n"
    "\n"
    "'systemctl status plumblined' shows what the daemon is waiting for. board/README.md explains the buttons.\n";

}  // namespace

CLI::App* add_press_command(CLI::App& app, PressOptions& options) {
  auto* command = app.add_subcommand("press", "Press a button of the running daemon");
  command->footer(kFooter);
  command->add_option("button", options.button, "start, pause or cancel")
      ->required()
      ->type_name("BUTTON")
      ->check(CLI::IsMember({"start", "pause", "cancel"}).description(""));
  command->add_option("--state", options.state, "The daemon's state folder [/var/lib/plumbline]")->type_name("DIR");
  return command;
}

ExitCode run_press(const PressOptions& options) {
  const auto pressed = press_button(options.state, options.button);
  return pressed ? ExitCode::kDone : report_error(pressed.error());
}

}  // namespace plumbline
