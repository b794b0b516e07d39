#include <CLI/CLI.hpp>

#include "firmware/archive/sl1_config.hpp"
#include "firmware/cli/commands.hpp"
#include "firmware/cli/options/accepted_values.hpp"
#include "firmware/io/output_file.hpp"
#include "firmware/io/progress_lines.hpp"
#include "firmware/io/version.hpp"
#include "firmware/settings/print_profile.hpp"

namespace plumbline::firmware {
namespace {

constexpr const char* kProfileFooter =
    "\nExamples:\n"
    "  plumbline profile --for prusaslicer --printer mono2k -o mono2k.ini\n"
    "  prusa-slicer --export-sla --load mono2k.ini part.stl -o part.sl1   slices for mono2k\n"
    "  plumbline print part.sl1 --printer mono2k                          prints it\n"
    "  plumbline profile --for uvtools --printer mono2k -o \"Plumbline mono2k.ini\"\n"
    "\n"
    "In PrusaSlicer: File, Import, Import Config. UVtools has PrusaSlicer slice: put its file into PrusaSlicer's "
    "folder\n"
    "\"printer\" (Help, Show Configuration Folder), and choose it there as the printer.\n"
    "\n"
    "Output: panel, travel, exposures, layer height, supports and, in the printer's notes, bottom layers, lifts and "
    "waits.\n"
    "An archive that is sliced with it prints as the profile says, also where the printer's own profile has changed.\n"
    "For UVtools the printer's part alone.\n";

Expected<std::string> profile_text(const ProfileOptions& options) {
  const auto board = read_board_file(options.printer);
  PLUMBLINE_TRY(board);
  const auto machine = machine_of(*board, board->path);
  PLUMBLINE_TRY(machine);
  const auto profile = read_print_profile(options.profile.empty() ? machine->profile : options.profile, board->path);
  PLUMBLINE_TRY(profile);
  std::string text = "# Written by plumbline " + std::string(kVersion) + " for the printer " + board->name +
                     " and the profile " + profile->name + "\n" + slicer_printer(*board, *machine, *profile);
  if (options.program == "prusaslicer") text += slicer_print(*profile);
  return text;
}

}  // namespace

CLI::App* add_profile_command(CLI::App& app, ProfileOptions& options) {
  auto* command = app.add_subcommand("profile", "Make a printer's profile for another slicer");
  command->footer(kProfileFooter);
  command->add_option("--for", options.program, "prusaslicer or uvtools")
      ->required()
      ->type_name("PROGRAM")
      ->check(one_of({"prusaslicer", "uvtools"}));
  command->add_option("--printer", options.printer, "The printer's name or board file")->required()->type_name("NAME");
  command->add_option("--profile", options.profile, "Resin and print settings, a name or a file [the printer's own]")
      ->type_name("NAME");
  command->add_option("-o,--output", options.output, "The file to write [standard output]")->type_name("INI");
  return command;
}

ExitCode run_profile(const ProfileOptions& options) {
  const auto text = profile_text(options);
  if (!text) return report_error(text.error());
  const auto written = options.output.empty() ? OutputFile::standard_output().write(std::string_view(*text))
                                              : write_file(options.output.c_str(), std::as_bytes(std::span(*text)));
  return written ? ExitCode::kDone : report_error(written.error());
}

}  // namespace plumbline::firmware
