#include "firmware/cli/command_line.hpp"

#include <CLI/CLI.hpp>
#include <memory>
#include <string>

#include "firmware/cli/options/help_format.hpp"
#include "firmware/cli/options/usage_error.hpp"
#include "firmware/io/progress_lines.hpp"
#include "firmware/io/version.hpp"

namespace plumbline::firmware {
namespace {

constexpr const char* kAbout =
    "Turns a 3D scan (a point cloud) into the layers of a resin print, and prints it.\n"
    "\n"
    "Try it:\n"
    "  plumbline sample bust.ply                          make a scan\n"
    "  plumbline inspect bust.ply --printer mono2k        see what is in it and whether it fits\n"
    "  plumbline slice bust.ply -o out --printer mono2k   write layers and pictures to out/\n"
    "  plumbline print bust.ply --printer sim2k           print it on the simulated printer\n"
    "  plumbline simulate bust.ply                        the same on the printer's page, in a browser\n"
    "\n"
    "On a printer's board: 'plumbline setup' makes its board file, 'plumbline doctor' checks it.\n"
    "Lengths are mm, angles degrees. 'plumbline slice --help' explains slice, and so on.\n";

}  // namespace

ExitCode run_command_line(int argc, char** argv, std::span<std::byte> arena_block) {
  CLI::App app(kAbout, "plumbline");
  app.set_version_flag("--version", std::string("plumbline ") + kVersion);
  app.require_subcommand(1);
  app.formatter(std::make_shared<HelpFormat>());

  SliceOptions slice;
  InspectOptions inspect;
  OrientOptions orient;
  PrintOptions print;
  CheckOptions check;
  SampleOptions sample;
  DoctorOptions doctor;
  StatusOptions status;
  ControlOptions control;
  SimulateOptions simulate;
  SetupOptions setup;
  ProfileOptions profile;
  const CLI::App* slice_command = add_slice_command(app, slice);
  const CLI::App* inspect_command = add_inspect_command(app, inspect);
  const CLI::App* orient_command = add_orient_command(app, orient);
  const CLI::App* print_command = add_print_command(app, print);
  const CLI::App* check_command = add_check_command(app, check);
  const CLI::App* sample_command = add_sample_command(app, sample);
  const CLI::App* status_command = add_status_command(app, status);
  const CLI::App* control_command = add_control_command(app, control);
  const CLI::App* simulate_command = add_simulate_command(app, simulate);
  const CLI::App* setup_command = add_setup_command(app, setup);
  const CLI::App* profile_command = add_profile_command(app, profile);
  add_doctor_command(app, doctor);

  try {
    app.parse(argc, argv);
  } catch (const CLI::Success& help_or_version) {
    app.exit(help_or_version);
    return ExitCode::kDone;
  } catch (const CLI::ParseError& error) {
    write_line(usage_message(app, error));
    return ExitCode::kUsageError;
  }
  if (slice_command->parsed()) return run_slice(slice, arena_block);
  if (inspect_command->parsed()) return run_inspect(inspect, arena_block);
  if (orient_command->parsed()) return run_orient(orient, arena_block);
  if (print_command->parsed()) return run_print(print, arena_block);
  if (check_command->parsed()) return run_check(check, arena_block);
  if (sample_command->parsed()) return run_sample(sample);
  if (status_command->parsed()) return run_status(status);
  if (control_command->parsed()) return run_control(control);
  if (simulate_command->parsed()) return run_simulate(simulate);
  if (setup_command->parsed()) return run_setup(setup);
  if (profile_command->parsed()) return run_profile(profile);
  return run_doctor(doctor);
}

}  // namespace plumbline::firmware
